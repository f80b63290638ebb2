// The pages say what is so: every command, key, scene, file and name in them exists, every example loads.

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "docs/faults.h"
#include "docs/markdown.h"
#include "pipeline/sweep/cells.h"

using namespace cloth::testing;
using Catch::Contains;
namespace fs = std::filesystem;

namespace {

const fs::path root = CLOTH_SOURCE_DIR;

const ProgramWords& known() {
    static const ProgramWords words = ask_program(RENDER_CLOTH_BINARY, root);
    return words;
}

/// README.md, CONTRIBUTING.md, docs/contact.md, …, relative to the source tree. The changelog may name what
/// is gone.
std::vector<fs::path> pages() {
    std::vector<fs::path> list;
    for (const char* folder : {".", "docs", "golden"})
        for (const auto& entry : fs::directory_iterator(root / folder))
            if (entry.path().extension() == ".md" && entry.path().filename() != "CHANGELOG.md")
                list.push_back((fs::path(folder) / entry.path().filename()).lexically_normal());
    std::sort(list.begin(), list.end());
    return list;
}

}  // namespace

TEST_CASE("the pages name no verb, flag, key, scene, fabric or file that is not there", "[docs]") {
    REQUIRE(pages().size() >= 5);
    for (const fs::path& page : pages())
        for (const std::string& fault : faults_of(read_text(root / page), page, root, known()))
            FAIL_CHECK(fault);
}

TEST_CASE("the README is short enough to be read", "[docs]") {
    const std::string text = read_text(root / "README.md");
    CHECK(std::count(text.begin(), text.end(), '\n') <= 150);
}

TEST_CASE("the pages tell of every verb and every flag", "[docs]") {
    std::string text;
    for (const fs::path& page : pages()) text += read_text(root / page);
    for (const auto& [name, verb] : known().verbs) {
        if (!name.empty() && name != "run") {  // it may be left out
            INFO(name);
            CHECK(text.find("render_cloth " + name) != std::string::npos);
        }
        for (const std::string& flag : verb.flags) {
            INFO(name + " " + flag);
            CHECK((flag == "--help" || text.find(flag) != std::string::npos));
        }
    }
}

TEST_CASE("the architecture's page has every room that stands", "[docs]") {
    const std::string page = read_text(root / "docs/architecture.md"),
                      list = read_text(root / "scripts/rooms.cmake");
    int rooms = 0;
    // set(sim base sim/algebra … sim/simulation)
    for (const char* tower : {"set(sim\n", "set(render\n", "set(validation ", "set(pipeline ", "set(apps "}) {
        const std::size_t begin = list.find(tower);
        REQUIRE(begin != std::string::npos);
        std::istringstream words(list.substr(begin, list.find(')', begin) - begin));
        std::string room;
        for (words >> room; words >> room;) {
            const bool stands = fs::exists(root / "src" / room) || fs::exists(root / "src" / (room + ".h")) ||
                                fs::exists(root / room) || fs::exists(root / (room + ".cpp"));
            if (!stands) continue;
            ++rooms;
            INFO(room);
            CHECK(page.find("| `" + room + "` |") != std::string::npos);
        }
    }
    CHECK(rooms > 20);
}

TEST_CASE("the sweeps that come with the program make cells", "[docs]") {
    int sweeps = 0;
    for (const auto& entry : fs::directory_iterator(root / "assets/sweeps")) {
        INFO(entry.path());
        CHECK(cloth::pipeline::cells_of(cloth::pipeline::load_sweep(entry.path())).cells.size() > 1);
        ++sweeps;
    }
    CHECK(sweeps > 0);
}

TEST_CASE("each kind of fault on a page is told with its line", "[docs]") {
    struct Bad {
        std::string markdown, fault;
    };
    const Bad table[] = {
        {"a\n\n[b](docs/nowhere.md)", "README.md:3: no file docs/nowhere.md"},
        {"# One\n[b](#two)", "README.md:2: no heading #two"},
        {"[b](golden/README.md#nowhere)", "no heading golden/README.md#nowhere"},
        {"    render_cloth fold --out DIR", "README.md:1: no verb fold"},
        {"`render_cloth fold`", "no verb fold"},
        {"    render_cloth encode --shade gap", "no flag --shade of encode"},
        {"x\n\n    render_cloth --scene NAME   what for\n        [--colour] [--out DIR]",
         "README.md:4: no flag --colour"},
        {"    ./demo --scene drape_cube", "no scene drape_cube"},
        {"`compare drape_cube`", "no scene drape_cube"},
        {"`validate cantalever --gamma 8`", "no check cantalever"},
        {"`validate drape --fabric tweed`", "no fabric tweed"},
        {"`list fabrics tweed`", "no fabric tweed"},
        {"`list flags`", "no list of flags"},
        {"`--set cloth.resolutoin=80`", "cloth.resolutoin"},
        {"`--set cloth.resolution=-80`", "cloth.resolution"},
        {"`--colour`", "no flag --colour"},
        {"`newton_sped = 0`", "no key newton_sped"},
        {"`contact = \"barier\"`", "neither the program nor its sources have `barier`"},
        {"`src/sim/nothing.h`", "no file src/sim/nothing.h"},
        {"`nothing.h`", "no file nothing.h"},
        {"    ./dmeo", "no file ./dmeo"},
        {"`build_modle()`", "neither the program nor its sources have `build_modle`"},
        {"`cmake --preset fast`", "no preset fast"},
        {"    cmake --build --preset release --target test_smi", "no target test_smi"},
        {"```toml\n[[cloth]]\nsise = [1.0, 1.0]\n```", "README.md:2: does not load: "},
        {"```toml\nversion = 1\nscene = \"cusick\"\n[grit]\n```", "README.md:2: does not load: "},
    };
    for (const Bad& bad : table) {
        const auto faults = faults_of(bad.markdown, "README.md", root, known());
        INFO(bad.markdown);
        REQUIRE(faults.size() == 1);
        CHECK_THAT(faults[0], Contains(bad.fault));
    }
}

TEST_CASE("what is right on a page passes", "[docs]") {
    for (const char* good : {
             "# A heading, with `code`\n[there](#a-heading-with-code) [far](https://example.org/x)",
             "    render_cloth --scene NAME|FILE --frames N       simulate, --not a flag\n        [--out "
             "DIR] [--size WxH]",
             "    ./demo --scene hanging_sheet --frames 60",
             "`--set cloth[0].fabric.bending=1e-4` `list fabrics --sources` `src/sim/` `report.json`",
             "`contact = \"barrier\"` `seed_drag` `cotton` `build_model()` `expect.frames` `y³/z`",
             "```toml\n[camera]\nturntable = 20\n```",
         }) {
        INFO(good);
        CHECK_THAT(faults_of(good, "README.md", root, known()), Catch::Equals(std::vector<std::string>{}));
    }
}

TEST_CASE("code, links and headings of a page are found with their lines", "[docs]") {
    const Page page = read_page(
        "# A `b` c\n\ntext `two\nlines` [x](y.md)\n\n    one\n\n    two\nend\n\n```toml\nk = 1\n```\n");
    REQUIRE(page.blocks.size() == 2);
    CHECK(page.blocks[0].line == 6);
    CHECK(page.blocks[0].text == "    one\n\n    two\n");
    CHECK(page.blocks[1].language == "toml");
    CHECK(page.blocks[1].text == "k = 1\n");
    CHECK(page.blocks[1].line == 12);
    REQUIRE(page.spans.size() == 2);
    CHECK(page.spans[1].text == "two lines");
    CHECK(page.spans[1].line == 3);
    REQUIRE(page.links.size() == 1);
    CHECK(page.links[0].line == 4);
    CHECK(page.anchors.contains("a-b-c"));
}
