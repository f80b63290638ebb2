#pragma once
// The two steps from TOML to a scene.

#include "pipeline/scene_file/reader.h"
#include "pipeline/scene_file/scene_file.h"

namespace cloth::pipeline {

/// Every key of the file into its place; of meshes and textures their names.
void read_scene(Reader& reader, SceneFile& file);

/// Mends the meshes of cloths (mesh_repair.h), takes pins, seams and poses along, and notes what was done;
/// notes as well what is far larger or smaller than all that it can meet. Reader::fail() where a pin or seam
/// has lost its vertices.
void mend_meshes(Reader& reader, SceneFile& file);
void note_sizes(SceneFile& file);

/// Loads the files, and checks what has to fit together. Reader::fail() where it does not.
void resolve(Reader& reader, SceneFile& file);

}  // namespace cloth::pipeline
