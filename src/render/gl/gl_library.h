#pragma once

namespace cloth::render {

/// What makes the context.
enum class GlLibrary {
    automatic,  ///< OSMesa, or EGL where that fails
    osmesa,     ///< up to Mesa 25.0
    egl,        ///< without window or display server; drawn in software, as by OSMesa
};

}  // namespace cloth::render
