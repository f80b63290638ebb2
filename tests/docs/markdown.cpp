#include "docs/markdown.h"

#include <algorithm>
#include <cctype>
#include <sstream>

namespace cloth::testing {
namespace {

/// A heading's name in links: lower case, spaces as hyphens, without what is neither letter, digit, - nor _.
std::string anchor_of(const std::string& heading) {
    std::string anchor;
    for (const char c : heading) {
        const auto byte = static_cast<unsigned char>(c);
        if (c == ' ') anchor += '-';
        if (std::isalnum(byte) || c == '-' || c == '_' || byte >= 0x80)
            anchor += static_cast<char>(std::tolower(byte));
    }
    return anchor;
}

int line_of(const std::string& text, std::size_t place) {
    return 1 + static_cast<int>(std::count(text.begin(), text.begin() + static_cast<long>(place), '\n'));
}

}  // namespace

Page read_page(const std::string& markdown) {
    Page page;
    std::string prose;  // the page with its code blocks blanked out, line for line
    std::istringstream lines(markdown);
    std::string line;
    bool fenced = false, indented = false, after_blank = true;
    for (int number = 1; std::getline(lines, line); ++number) {
        const bool blank = line.find_first_not_of(' ') == std::string::npos;
        const bool fence = line.starts_with("```");
        if (fence) fenced = !fenced;
        if (fence && fenced) page.blocks.push_back({number + 1, line.substr(3), ""});
        const bool goes_on = indented && (blank || line.starts_with("    "));
        indented = !fence && !fenced && (goes_on || (after_blank && !blank && line.starts_with("    ")));
        if (indented && !goes_on) page.blocks.push_back({number, "", ""});

        const bool code = fence || fenced || indented;
        if (code && !fence) page.blocks.back().text += line + '\n';
        if (!code && line.starts_with("#"))
            page.anchors.insert(anchor_of(line.substr(line.find_first_not_of("# "))));
        prose += code ? "\n" : line + '\n';
        after_blank = blank;
    }

    for (std::size_t begin = prose.find('`'); begin != std::string::npos; begin = prose.find('`', begin)) {
        const std::size_t end = prose.find('`', begin + 1);
        if (end == std::string::npos) break;
        std::string text = prose.substr(begin + 1, end - begin - 1);
        std::replace(text.begin(), text.end(), '\n', ' ');
        page.spans.push_back({line_of(prose, begin), "", text});
        begin = end + 1;
    }
    for (std::size_t at = prose.find("]("); at != std::string::npos; at = prose.find("](", at + 2)) {
        const std::size_t end = prose.find(')', at);
        if (end == std::string::npos) break;
        page.links.push_back({line_of(prose, at), prose.substr(at + 2, end - at - 2)});
    }
    return page;
}

}  // namespace cloth::testing
