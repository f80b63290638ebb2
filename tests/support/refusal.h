#pragma once
// What a bad scene is refused with.

#include <functional>
#include <string>

#include "sim/scene/scene.h"

/// Message of the SceneError that `action` throws, and its place in `key`; "accepted" where it throws none.
inline std::string refusal(const std::function<void()>& action, std::string* key = nullptr) {
    try {
        action();
    } catch (const cloth::SceneError& error) {
        if (key) *key = error.key;
        return error.what();
    }
    return "accepted";
}

/// A good scene made bad, and the place and a part of the message that it must be refused with.
struct Spoiled {
    const char* key;
    const char* message;
    std::function<void(cloth::Scene&)> spoil;
};
