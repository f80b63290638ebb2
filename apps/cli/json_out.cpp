#include "apps/cli/json_out.h"

#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>

namespace cloth::cli {
namespace {

/// Names of files may be any bytes.
void print(const nlohmann::ordered_json& json, int indent) {
    fmt::print("{}\n", json.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
    std::fflush(stdout);
}

}  // namespace

void print_json_line(const nlohmann::ordered_json& json) {
    print(json, -1);
}

void print_json(const nlohmann::ordered_json& json) {
    print(json, 1);
}

}  // namespace cloth::cli
