#pragma once
// Memory for what passes write: whole pages, huge ones where it is large, so that walking it costs few misses of the
// page tables.

#include <cstddef>
#include <memory>

namespace gnomon {

// At least `bytes`, not initialised; large ones start at a huge page. Throws std::bad_alloc.
std::byte* allocate_pages(size_t bytes);
void release_pages(std::byte* pages, size_t bytes) noexcept;

// An array of that kind. Elements are trivial and start without a value.
template <class T> class PageArray {
public:
    explicit PageArray(size_t count)
        : values_(reinterpret_cast<T*>(allocate_pages(count * sizeof(T))), Release{count * sizeof(T)}), count_(count) {}

    T* data() { return values_.get(); }
    const T* data() const { return values_.get(); }
    size_t size() const { return count_; }
    const T& operator[](size_t i) const { return values_[i]; }

private:
    struct Release {
        size_t bytes;
        void operator()(T* values) const { release_pages(reinterpret_cast<std::byte*>(values), bytes); }
    };
    std::unique_ptr<T[], Release> values_;
    size_t count_;
};

} // namespace gnomon
