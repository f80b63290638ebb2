#pragma once
// Reads a scene file's tables by their fields, with overrides laid over it; every fault has its place.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <toml++/toml.h>

#include "pipeline/scene_file/field.h"
#include "pipeline/scene_file/scene_file.h"

namespace cloth::pipeline {

/// Throws Error(invalid_scene) with `message` as one line.
[[noreturn]] void refuse_scene(const std::string& message);

/// Throws Error, with the override's exit code, in the words that the user typed.
[[noreturn]] void refuse_override(const Override& wanted, const std::string& key, const std::string& message);

class Reader {
  public:
    /// `label` stands for the file in messages, relative paths start at `folder`.
    Reader(std::string label, std::filesystem::path folder)
        : label_(std::move(label)), folder_(std::move(folder)) {}

    void parse(const std::string& text);
    void override_key(const Override& wanted);

    /// Reads a table's values by its fields; `nested` lists keys that are tables of their own.
    void read(const toml::table& table, const std::string& path, const Fields& fields,
              const std::vector<std::string>& nested = {});

    /// A table of the root; null where there is none.
    const toml::table* table(const std::string& key);
    /// The tables of a list of the root.
    std::vector<const toml::table*> list(const std::string& key);
    const toml::table& root() const { return root_; }

    /// What a dotted key ("cloth[0].fabric") holds; null where the file does not have it.
    const toml::node* find(const std::string& key) const;

    /// Throws for a dotted key, at the place of the deepest part of it that the file has.
    [[noreturn]] void fail(const std::string& key, const std::string& message);

    /// Relative paths start at the scene file's folder, then at the working folder.
    std::filesystem::path find_file(const std::string& name) const;

  private:
    [[noreturn]] void fail_at(const toml::source_region& place, const std::string& key,
                              const std::string& message);

    std::string label_;
    std::filesystem::path folder_;
    toml::table root_;
    std::map<std::string, Override> overridden_;  ///< by full key
};

}  // namespace cloth::pipeline
