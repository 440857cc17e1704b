#include "bin/technique_pages.h"

#include <algorithm>

#include <fmt/format.h>

namespace gnomon {
namespace {

// Text with nothing in it that Markdown or a table would take for its own; `code` between backticks stays.
std::string escaped(const std::string& text) {
    std::string result;
    bool code = false;
    for (const char letter : text) {
        if (letter == '`') code = !code;
        if (letter == '|' || (!code && std::string_view("\\*_<>[]").find(letter) != std::string_view::npos))
            result += '\\';
        result += letter;
    }
    return result;
}

// Equations are shown as they are written.
std::string equations(const std::string& text) {
    return text.find_first_of("=^") == std::string::npos ? escaped(text) : fmt::format("`{}`", text);
}

std::string values(const ParameterInfo& info) {
    if (!info.choices.empty()) return fmt::format("{}", fmt::join(info.choices, ", "));
    if (info.type == ParameterType::Boolean) return "true, false";
    return fmt::format("{} to {}{}{}", info.minimum, info.maximum, info.unit.empty() ? "" : " ", escaped(info.unit));
}

std::string parameter_rows(const Entry& entry) {
    if (entry.parameters.empty()) return "It has none.\n";
    std::string text = "| name | default | values | meaning | source |\n|---|---|---|---|---|\n";
    for (const ParameterInfo& info : entry.parameters)
        text += fmt::format("| `{}` | {} | {} | {} | {} |\n", info.name, escaped(info.default_text), values(info),
                            escaped(info.help), escaped(info.source));
    const bool of_the_author =
        std::any_of(entry.parameters.begin(), entry.parameters.end(), [](const ParameterInfo& info) {
            return info.source.find("author's programs") != std::string::npos;
        });
    if (of_the_author)
        text +=
            "\nThe author's programs are those that Macedo published: github.com/MarcioCerqueira/GlobalIllumination.\n";
    return text;
}

// What its picture compares it with.
std::string caption(const TechniqueInfo& info) {
    const bool soft = info.kind == TechniqueKind::Soft;
    const std::string beside = info.id == "truth"               ? "ray-traced hard shadows"
                               : soft || info.id == "raytraced" ? "the truth of the area light"
                                                                : "ray-traced hard shadows of the light's centre";
    return fmt::format("`{}` with its defaults on the default scene; the marked place larger, and below it {}.",
                       info.id, beside);
}

std::vector<std::string> families() {
    std::vector<std::string> names;
    for (const Entry& entry : techniques())
        if (std::find(names.begin(), names.end(), entry.info.family) == names.end()) names.push_back(entry.info.family);
    return names;
}

const char* const made_by = "<!-- Made by `gnomon docs -o docs/techniques` from the registry. -->\n";

} // namespace

std::string technique_page(const Entry& entry) {
    const TechniqueInfo& info = entry.info;
    std::string text = fmt::format("{}# {}: {}\n\n![{}]({}.png)\n\n*{}*\n\n", made_by, info.id, escaped(info.title),
                                   escaped(info.title), info.id, caption(info));
    text += "| | |\n|---|---|\n";
    const auto row = [&](const char* name, const std::string& value) {
        text += fmt::format("| {} | {} |\n", name, value);
    };
    row("family", escaped(info.family));
    row("kind", technique_kind_name(info.kind));
    row("lights", fmt::format("{}", fmt::join(light_type_names(info.lights), ", ")));
    row("paper", escaped(info.paper));
    row("section", escaped(info.section));
    row("equations", equations(info.equations));
    row("strengths", escaped(info.strengths));
    row("known artifacts", escaped(info.artifacts));
    text += fmt::format("\n## Parameters\n\n{}\n", parameter_rows(entry));
    return text + fmt::format("```\ngnomon render -t {}{} -o {}.png\n```\n", info.id,
                              entry.parameters.empty()
                                  ? ""
                                  : ":" + entry.parameters.front().name + "=" + entry.parameters.front().default_text,
                              info.id);
}

std::string technique_index() {
    std::string text = fmt::format("{}# Techniques\n\nWhat `gnomon help ID` tells, with a picture of each.\n", made_by);
    for (const std::string& family : families()) {
        std::string title = family;
        title.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(title.front())));
        text += fmt::format("\n## {}\n\n| technique | | kind and paper | |\n|---|---|---|---|\n", escaped(title));
        for (const Entry& entry : techniques())
            if (entry.info.family == family)
                text += fmt::format(
                    "| [{0}]({0}.md) | {1} | {2}: {3} | <img src=\"{0}.png\" width=\"300\" alt=\"{0}\"> |\n",
                    entry.info.id, escaped(entry.info.title), technique_kind_name(entry.info.kind),
                    escaped(entry.info.paper));
    }
    return text;
}

} // namespace gnomon
