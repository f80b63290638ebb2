// The frames in a page: what they take, what is left out for it, and that nothing of it is lost on the way.

#include "pipeline/page/view_data.h"

#include <libdeflate.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "pipeline/page/page.h"

using namespace cloth;
using namespace cloth::pipeline;

namespace {

/// Of `n` vertices, and a collider of `m` triangles.
ExportScene scene_of(int n, int m = 1) {
    ExportScene scene;
    scene.topology.rest_positions = Points::Zero(n, 3);
    scene.topology.triangles = Triangles::Zero(1, 3);
    scene.topology.cloths = {{"sheet", 0, n, 0, 1}};
    scene.materials.resize(1);
    Surface surface;
    surface.positions = Points::Random(3 * m, 3);
    surface.triangles = Triangles::Zero(m, 3);
    scene.colliders.push_back({"ball", surface, {}, false});
    return scene;
}

/// Noise: nothing can be compressed.
ExportFrame noise(std::int64_t index, int n) {
    std::mt19937 random(static_cast<unsigned>(index) + 1);
    std::uniform_real_distribution<double> share(0.0, 1.0);
    ExportFrame frame{};
    frame.index = index;
    frame.positions = Points::NullaryExpr(n, 3, [&] { return share(random); });
    frame.colliders.resize(1);
    return frame;
}

ViewField field_of(std::function<VecX(const ExportFrame&)> values, bool log = false) {
    return {"height",
            "height",
            "m",
            std::move(values),
            [](const std::vector<double>&, double) {
                return ShadeRange{0.01, 1.0};
            },
            log};
}
VecX heights(const ExportFrame& frame) {
    return frame.positions.col(1);
}

std::string bytes_of(const std::string& base64) {
    static const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string bytes;
    unsigned bits = 0;
    int count = 0;
    for (const char c : base64) {
        if (c == '=') break;
        bits = bits << 6 | static_cast<unsigned>(digits.find(c));
        if ((count += 6) >= 8) bytes += static_cast<char>(bits >> (count -= 8) & 255U);
    }
    return bytes;
}

std::string unpacked(const nlohmann::ordered_json& view, std::size_t size) {
    const std::string packed = bytes_of(view["data"]);
    std::string bytes(size, '\0');
    libdeflate_decompressor* const decompressor = libdeflate_alloc_decompressor();
    const auto result = libdeflate_zlib_decompress(decompressor, packed.data(), packed.size(), bytes.data(),
                                                   bytes.size(), nullptr);
    libdeflate_free_decompressor(decompressor);
    REQUIRE(result == LIBDEFLATE_SUCCESS);
    return bytes;
}

}  // namespace

TEST_CASE("frames in a page are positions to 65,536ths of their box, and fields as colours", "[page]") {
    constexpr int n = 40;
    const ExportScene scene = scene_of(n);
    ViewRecorder recorder(
        {field_of(heights), field_of(heights, /*log=*/true),
         field_of([](const auto& f) -> VecX { return VecX::Constant(f.positions.rows(), std::nan("")); })},
        1'000'000);
    recorder.begin(scene);
    const std::vector<ExportFrame> frames{noise(0, n), noise(4, n)};
    for (const ExportFrame& frame : frames) recorder.frame(frame);
    recorder.end();
    const auto& view = recorder.view();
    CHECK(view["frames"] == nlohmann::json({0, 4}));
    CHECK(view["every"] == 1);
    CHECK(view["left_out"].empty());

    const std::size_t fixed = 12 + 36 + 12, frame_size = 6 * n + 3 * n;
    const std::string bytes = unpacked(view, fixed + 2 * frame_size);
    const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(bytes[at]); };
    std::vector<unsigned> last(3 * n, 0);
    for (std::size_t f = 0; f < 2; ++f) {
        const std::size_t at = fixed + f * frame_size;
        for (std::size_t axis = 0; axis < 3; ++axis)
            for (std::size_t v = 0; v < n; ++v) {
                const std::size_t lower = at + 2 * n * axis + v;
                unsigned& share = last[axis * n + v];
                share = (share + byte(lower) + 256U * byte(lower + n)) & 65535U;
                const double low = view["low"][axis], size = view["size"][axis];
                const auto row = static_cast<Eigen::Index>(v), column = static_cast<Eigen::Index>(axis);
                // Half a step of the grid.
                CHECK(std::abs(low + size * share / 65535.0 - frames[f].positions(row, column)) <=
                      0.5001 * size / 65535.0);
            }
        for (std::size_t v = 0; v < n; ++v) {
            const double height = frames[f].positions(static_cast<Eigen::Index>(v), 1);
            CHECK(byte(at + 6 * n + v) == Approx(254 * std::max(0.0, (height - 0.01) / 0.99)).margin(0.51));
            CHECK(byte(at + 7 * n + v) ==
                  Approx(254 * std::max(0.0, std::log(height / 0.01) / std::log(100.0))).margin(0.51));
            CHECK(byte(at + 8 * n + v) == 255);  // there is no number
        }
    }
}

TEST_CASE("frames that find no room in a page are left out evenly, and it says how many", "[page]") {
    constexpr int n = 2000;
    constexpr std::size_t most = 100'000;
    const ExportScene scene = scene_of(n);
    ViewRecorder recorder({field_of(heights)}, most);
    recorder.begin(scene);
    for (std::int64_t k = 0; k < 40; ++k) recorder.frame(noise(k, n));
    recorder.end();
    const auto& view = recorder.view();
    CHECK(view["data"].get<std::string>().size() <= most);
    CHECK(view["data"].get<std::string>().size() > most / 3);
    const std::int64_t every = view["every"];
    CHECK(every > 1);
    for (std::size_t f = 0; f < view["frames"].size(); ++f)
        CHECK(view["frames"][f] == every * static_cast<std::int64_t>(f));
    CHECK(40 - view["frames"].back().get<std::int64_t>() <= every);
    // As many as the run has are told of beforehand, about.
    CHECK(view_stride(40, n, 1, most) == Approx(static_cast<double>(every)).margin(3));
}

TEST_CASE("a collider too large for a page is left out by name, a cloth too large leaves nothing", "[page]") {
    const ExportScene scene = scene_of(30, 20'000);
    ViewRecorder recorder({}, 100'000);
    recorder.begin(scene);
    recorder.frame(noise(0, 30));
    recorder.end();
    CHECK(recorder.view()["left_out"] == nlohmann::json({"ball"}));
    CHECK(recorder.view()["colliders"].empty());
    CHECK(recorder.view()["data"].get<std::string>().size() < 1000);

    const ExportScene large = scene_of(30'000);
    ViewRecorder none({}, 100'000);
    none.begin(large);
    for (std::int64_t k = 0; k < 3; ++k) none.frame(noise(k, 30'000));
    none.end();
    CHECK(none.view()["data"] == "");
}

TEST_CASE("no text in a page ends its script or is taken for markup", "[page]") {
    nlohmann::ordered_json data;
    data["title"] = "</title><b>&\"";
    data["mark"] = "<!-- mark -->";
    data["lines"] = {"</script><script>alert(1)</script>", "<!--", "@STYLE@ \xff\xfe"};
    data["runs"] = nlohmann::json::array();
    const std::string page = page_text(data);
    CHECK_THAT(page, Catch::Contains("<title>&lt;/title&gt;&lt;b&gt;&amp;&quot;</title>"));
    CHECK_THAT(page, !Catch::Contains("alert(1)</script>"));
    const std::string begin = "id=\"data\">";
    const std::size_t from = page.find(begin) + begin.size(), to = page.find("</script>", from);
    const std::string json = page.substr(from, to - from);
    CHECK(json.find('<') == std::string::npos);
    const auto again = nlohmann::json::parse(json);
    CHECK(again["lines"][0] == "</script><script>alert(1)</script>");
    CHECK_THAT(again["lines"][2].get<std::string>(), Catch::StartsWith("@STYLE@ "));
}
