#pragma once
// What a Markdown page says in code, and where it points: as much of the language as this project's pages
// use.

#include <set>
#include <string>
#include <vector>

namespace cloth::testing {

struct Code {
    int line;              ///< of the page, from 1, where it begins
    std::string language;  ///< of a fenced block
    std::string text;
};

struct Link {
    int line;
    std::string target;  ///< "docs/contact.md#measured"
};

struct Page {
    std::vector<Code> blocks;       ///< fenced, or indented by four spaces
    std::vector<Code> spans;        ///< `between backticks`, line breaks as spaces
    std::vector<Link> links;        ///< of texts and of pictures
    std::set<std::string> anchors;  ///< of its headings
};

Page read_page(const std::string& markdown);

}  // namespace cloth::testing
