#pragma once
// The folder of a study. Whatever appears in it is whole: it is made in a scratch folder beside its place and renamed
// there. Several runs, on several machines, may fill one folder at once; scratch folders of runs that died are
// removed by the next.
//
//   study.json                            rows of the study that was last run, for `collect`
//   results.jsonl results.csv             what came out, without times
//   timings.jsonl timings.csv             how long it took
//   cells/HASH/result.json                identity, metrics, counters, passes; or why it failed
//   cells/HASH/visibility.exr
//   cells/HASH/timing.json
//   truths/HASH.exr

#include <optional>
#include <string>

#include "eval/study/study.h"

namespace gnomon {

// The right to compute a truth, and to use its state, among all runs that share a folder; held for as long as it lives.
class TruthClaim {
public:
    // Waits where another run holds the claim and `wait` is set. Not held where one does and it is not set, nor where
    // the file system knows no locks: then every run is on its own.
    TruthClaim(std::string path, bool wait);
    ~TruthClaim();
    TruthClaim(const TruthClaim&) = delete;
    TruthClaim& operator=(const TruthClaim&) = delete;

    bool held() const { return descriptor_ >= 0; }

private:
    std::string path_;
    int descriptor_ = -1;
};

class StudyStore {
public:
    // Touches nothing until something is put there.
    explicit StudyStore(std::string folder) : folder_(std::move(folder)) {}
    ~StudyStore();
    StudyStore(const StudyStore&) = delete;
    StudyStore& operator=(const StudyStore&) = delete;

    const std::string& folder() const { return folder_; }
    // Removes the scratch folders of runs that died.
    void remove_abandoned() const;

    // The cell's result.json where the cell is there, whole and of this identity; else nothing.
    std::optional<nlohmann::ordered_json> result(const std::string& hash) const;
    // null where there is none.
    nlohmann::ordered_json timing(const std::string& hash) const;
    // `image` is null for a cell that failed. Throws InputError.
    void put_cell(const std::string& hash, nlohmann::ordered_json result, const nlohmann::ordered_json& timing,
                  const ChannelImage* image);

    // Nothing where the file is missing or broken.
    std::optional<ChannelImage> truth(const std::string& hash) const;
    void put_truth(const std::string& hash, const ChannelImage& image);
    TruthClaim claim_truth(const std::string& hash, bool wait);
    // Where a truth keeps what it has so far; only for who holds its claim.
    std::string truth_state(const std::string& hash) const { return path("claims/" + hash + ".partial"); }
    // Removes claims that a run left behind which died just after it had put the truth there.
    void tidy(const std::string& truth_hash);

    // A file of the folder itself; left alone where it has these bytes already.
    void put_text(const std::string& name, const std::string& text);
    std::string text(const std::string& name) const; // throws InputError

private:
    std::string path(const std::string& name) const { return folder_ + "/" + name; }
    const std::string& scratch();
    void make_folder(const std::string& name);

    std::string folder_;
    std::string scratch_; // of this run; empty before it is needed
    int scratch_lock_ = -1;
};

} // namespace gnomon
