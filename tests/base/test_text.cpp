#include "base/text.h"

#include <catch2/catch.hpp>

using namespace cloth;

TEST_CASE("the distance of two words counts inserted, removed and replaced letters", "[text]") {
    CHECK(edit_distance("", "") == 0);
    CHECK(edit_distance("sphere", "sphere") == 0);
    CHECK(edit_distance("spere", "sphere") == 1);
    CHECK(edit_distance("kitten", "sitting") == 3);
    CHECK(edit_distance("", "abc") == 3);
}

TEST_CASE("the nearest word is at most two edits off, or a third of its length, not all of it", "[text]") {
    CHECK(nearest_word("coton", {"denim", "cotton", "wool"}) == "cotton");
    CHECK(nearest_word("coton", {}) == "");
    CHECK(nearest_word("abc", {"xyz"}) == "");
    CHECK(nearest_word("w", {"x"}) == "");
    CHECK(nearest_word("", {"x"}) == "");
    CHECK(nearest_word("implct_eler", {"implicit_euler"}) == "implicit_euler");
}

TEST_CASE("texts are joined and split", "[text]") {
    CHECK(join({}) == "");
    CHECK(join({"a", "b", "c"}) == "a, b, c");
    CHECK(join({"a", "b"}, "|") == "a|b");
    CHECK(split("a,b,,c", ',') == std::vector<std::string>{"a", "b", "", "c"});
    CHECK(split("", ',') == std::vector<std::string>{""});
}

TEST_CASE("a message keeps to one line, whatever it holds", "[text]") {
    CHECK(one_line("a\nb\r\tc\x1b[0m\x7f ü") == "a b  c [0m  ü");
}

TEST_CASE("text inside HTML or SVG is escaped", "[text]") {
    CHECK(escaped("a < b && \"c\" > d") == "a &lt; b &amp;&amp; &quot;c&quot; &gt; d");
}
