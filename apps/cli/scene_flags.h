#pragma once
// Flags that stand for keys of a scene. The scene file's own rules judge their values: no range is said here.

#include <deque>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/cli/command_line.h"
#include "pipeline/run/run.h"
#include "pipeline/scene_file/scene_file.h"

namespace cloth::cli {

/// --set, and flags that are short for it.
class KeyFlags {
  public:
    void add_set(Flags& flags);                                                        ///< --set KEY=VALUE
    void add_frames(Flags& flags, const std::string& value, const std::string& help);  ///< --frames
    void add_preview(Flags& flags);                                                    ///< --preview
    void add_size(Flags& flags);                                                       ///< --size WxH
    void add_fps(Flags& flags);                                                        ///< --fps F
    void add_annotation(Flags& flags);  ///< --caption, --shade, …: what is drawn over the pictures

    /// For a scene whose states are there already: --fps is the movie's rate, --frames no key.
    pipeline::Overrides redraw_overrides() const;
    /// The scene to be simulated. --fps sets the movie's rate. In a scene without a playback rate of its own
    /// time runs true, and it keeps doing so: the simulation makes as many frames per second.
    pipeline::SceneFile load(const std::string& name_or_path) const;
    /// The same of a kept run's folder; as many frames as that has, where --frames does not say.
    pipeline::SceneFile load_run(const std::filesystem::path& out) const;
    /// --frames A:B, where it is given. Throws Error(usage).
    std::optional<pipeline::FrameSpan> span() const;

    /// Whether --size was given.
    bool has_size() const;

  private:
    /// How a flag's text becomes TOML.
    using Form = std::string (*)(const std::string& text);
    /// A flag that stands for a key, and its text; empty: not given.
    struct Forwarded {
        std::string flag, key;
        Form form;
        std::string text;
    };

    void forward(Flags& flags, const Flag& flag, const std::string& key, Form form);
    /// Behind what --set says, flags: they are the more deliberate of the two.
    pipeline::Overrides overrides() const;

    std::vector<std::string> set_;
    std::deque<Forwarded> forwarded_;  // stay where they are when more are added
    std::string frames_, fps_;
    bool caption_ = false, wireframe_ = false, preview_ = false;
};

/// What a verb that simulates is asked: a scene, its keys, and a folder.
struct SceneFlags {
    std::string scene, out;
    KeyFlags keys;

    /// --scene, --out and all keys of the simulation.
    void add(Flags& flags);
    /// Throws Error(usage) where no scene is named.
    pipeline::SceneFile load() const;
    /// --out, by default out/NAME.
    std::filesystem::path folder(const pipeline::SceneFile& file) const;
};

}  // namespace cloth::cli
