#include "pipeline/page/page.h"

#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "base/text.h"
#include "pipeline/formats/base64.h"
#include "pipeline/page/page_texts.h"

namespace cloth::pipeline {
namespace {

using Part = std::pair<std::string_view, std::string>;

/// A template with its marks replaced, each once.
std::string filled(std::string_view text, const std::initializer_list<Part>& parts) {
    std::string page;
    while (true) {
        const Part* next = nullptr;
        std::size_t at = text.npos;
        for (const Part& part : parts) {
            if (const std::size_t found = text.find(part.first); found < at) {
                at = found;
                next = &part;
            }
        }
        page += text.substr(0, at);
        if (next == nullptr) return page;
        page += next->second;
        text.remove_prefix(at + next->first.size());
    }
}

std::string script(const std::string& text) {
    return "<script>\n" + text + "\n</script>\n";
}

/// JSON that no tag can end.
std::string embedded(const nlohmann::ordered_json& data) {
    std::string text = data.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace), safe;
    safe.reserve(text.size());
    for (const char c : text) {
        if (c == '<') {
            safe += "\\u003c";
        } else {
            safe += c;
        }
    }
    return safe;
}

}  // namespace

std::string page_text(const nlohmann::ordered_json& data) {
    const auto runs = data.find("runs");
    const bool with_runs = runs != data.end() && !runs->empty();
    std::string style = page_texts::page_css, scripts;
    if (with_runs) {
        style = page_texts::dygraph_min_css + style;
        scripts = page_texts::licences_txt + script(page_texts::dygraph_min_js) +
                  script(page_texts::three_min_js) + script(page_texts::OrbitControls_js);
    }
    // Each uses what those before it have.
    for (const char* text :
         {page_texts::base_js, page_texts::player_js, page_texts::charts_js, page_texts::unpack_js,
          page_texts::view_js, page_texts::golden_js, page_texts::page_js})
        scripts += script(text);
    return filled(page_texts::page_html, {{"@MARK@", data.value("mark", "")},
                                          {"@TITLE@", escaped(data.value("title", ""))},
                                          {"@STYLE@", style},
                                          {"@DATA@", embedded(data)},
                                          {"@SCRIPTS@", scripts}});
}

std::string picture_url(std::string_view png) {
    return "data:image/png;base64," + base64(png);
}

}  // namespace cloth::pipeline
