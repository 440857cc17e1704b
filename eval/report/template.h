#pragma once
// The report's page, style and script: the files of data/report, compiled into the program by
// cmake/report_template.cmake so that an installed program needs no data files.

#include <string_view>

namespace gnomon {

extern const std::string_view report_html, report_style, report_script;

} // namespace gnomon
