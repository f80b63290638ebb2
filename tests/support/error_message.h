#pragma once
// What the pipeline refuses with.

#include <catch2/catch.hpp>
#include <functional>
#include <string>

#include "pipeline/formats/error.h"

/// Message of the Error that `work` throws, which must have this exit code.
inline std::string message_of(const std::function<void()>& work, cloth::pipeline::ExitCode code) {
    try {
        work();
    } catch (const cloth::pipeline::Error& e) {
        CHECK(e.code == code);
        return e.what();
    }
    FAIL("no Error");
    return {};
}
