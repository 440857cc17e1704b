// Tables and claims on the report's page.

#include <catch2/catch.hpp>

#include "eval/report/report.h"
#include "tests/eval/browser.h"
#include "tests/support.h"

using namespace gnomon;
using gnomon_tests::Browser;
using nlohmann::json;

TEST_CASE("a page shows a study's tables and claims", "[browser]") {
    const std::string program = gnomon_tests::chromium_path();
    if (program.empty()) return;
    ReportData data;
    data.kind = ReportData::Kind::Study, data.title = "Findings";
    data.findings = nlohmann::ordered_json::parse(R"~({
        "tables": [{"name": "Table 1", "title": "errors </script><b>", "source": "p. 1", "note": "", "parts": [
            {"title": "root mean square error", "keys": ["scene", "parameters.size"], "columns": ["a", "b"], "rows": [
                {"labels": ["fence", "512"], "texts": ["0.5", "failed"]}, {"labels": ["fence", "1024"], "texts": ["0.25 (-50.0 %)", ""]}]},
            {"title": "CPU time", "keys": ["scene", "parameters.size"], "columns": ["a", "b"], "rows": []}]}],
        "claims": [{"id": "C1", "text": "It holds.", "source": "p. 2", "verdict": "holds", "note": "", "checks": []},
                   {"id": "C2", "text": "It does not.", "source": "", "verdict": "does not hold", "note": "Because.", "checks": [
                    {"text": "in words", "formula": "rmse < 1", "verdict": "does not hold", "measured": "2", "groups": []}]}],
        "skipped": [], "notes": ["One more thing."]})~");
    const std::string page = gnomon_tests::temporary_folder() + "/report.html";
    write_report(page, data);
    Browser browser(program);
    browser.open(page, "document.documentElement.dataset.ready === 'yes'");
    const auto texts = [&](const std::string& selector) {
        return browser.evaluate("[...document.querySelectorAll(" + json(selector).dump() +
                                ")].map(one => one.textContent)");
    };
    CHECK(texts("#tables > details > summary") == json{"Table 1: errors </script><b>"});
    CHECK(texts("#tables > details > .scroll thead th") == json{"scene", "size", "a", "b"});
    CHECK(texts("#tables > details > .scroll tbody th") == json{"fence", "512", "", "1024"});
    CHECK(texts("#tables > details > .scroll tbody td") == json{"0.5", "failed", "0.25 (-50.0 %)", "–"});
    CHECK(texts("#tables details details summary") == json{"CPU time"});
    CHECK(texts("#claims > .note") == json{"1 holds, 1 does not hold"});
    CHECK(texts(".claim summary") == json{"C1 It holds. holds", "C2 It does not. does not hold"});
    CHECK(browser.evaluate("[...document.querySelectorAll('.claim')].map(one => one.open)") == json{false, true});
    CHECK(texts(".claim[open] td") == json{"in words: rmse < 1", "2", "does not hold"});
    CHECK(texts("#study-notes li") == json{"One more thing."});
    CHECK(texts("#nav-study a") == json{"Claims", "Tables", "Notes"});
    CHECK(browser.complaints().empty());
}
