// What is exported as glTF, read by assimp.

#include <assimp/anim.h>
#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#include <catch2/catch.hpp>
#include <string>

#include "pipeline/formats/exporters.h"
#include "sim/scene/mesh.h"
#include "support/temporary_folder.h"

using namespace cloth;
using namespace cloth::pipeline;

namespace {

/// Of a float near 1 m, and of the difference of two.
constexpr double float_error = 2e-7;

Points positions_of(const ExportScene& scene, int frame) {
    Points positions = scene.topology.rest_positions;
    for (Eigen::Index i = 0; i < positions.rows(); ++i)
        positions(i, 2) = 0.1 * frame * positions(i, 0) * positions(i, 0);
    return positions;
}

/// Two cloths of 4 x 3 and 3 x 3 vertices, and a box that moves; frames 2 to 5 at 25 a second.
ExportScene two_cloths() {
    const MeshData a = make_grid({.resolution = {4, 3}}), b = make_grid({.resolution = {3, 3}});
    ExportScene scene;
    scene.name = "two";
    scene.topology.rest_positions.resize(21, 3);
    scene.topology.rest_positions << a.positions, b.positions;
    scene.topology.triangles.resize(12 + 8, 3);
    scene.topology.triangles << a.triangles, b.triangles.array() + 12;
    scene.topology.cloths = {{"a", 0, 12, 0, 12}, {"b", 12, 9, 12, 8}};
    scene.uv = scene.topology.rest_positions.leftCols(2);
    scene.materials.resize(2);
    scene.materials[1].front = {0.25f, 0.5f, 0.75f};
    scene.colliders.push_back({"box", make_shape({.shape = Shape::box})->surface(), {}});
    scene.frame_rate = 25.0;
    scene.frames = {2, 3, 4, 5};
    return scene;
}

void check_points(const aiVector3D* read, const Points& written) {
    for (Eigen::Index i = 0; i < written.rows(); ++i) {
        CHECK(read[i].x == Approx(written(i, 0)).margin(float_error));
        CHECK(read[i].y == Approx(written(i, 1)).margin(float_error));
        CHECK(read[i].z == Approx(written(i, 2)).margin(float_error));
    }
}

}  // namespace

TEST_CASE("assimp reads cloths, frames, times, materials and colliders of a glTF", "[exporters]") {
    const ExportScene scene = two_cloths();
    for (const std::string name : {"m.glb", "m.gltf"}) {
        INFO(name);
        const TemporaryFolder folder;
        const auto exporter = export_format("", name).make(folder / name, FrameNames::numbered);
        exporter->begin(scene);
        for (const std::int64_t k : scene.frames) {
            Placement placement;
            placement.translation.x() = 0.5 * static_cast<double>(k);
            exporter->frame({k,
                             scene.time(k),
                             positions_of(scene, static_cast<int>(k)),
                             Points::Zero(21, 3),
                             {{true, placement}},
                             {Vec3(0.0, 0.0, 3.0), Vec3::Zero(), Vec3::UnitY(), 35.0},
                             {}});
        }
        exporter->end();

        Assimp::Importer importer;
        const aiScene* read = importer.ReadFile((folder / name).string(), 0);
        INFO(importer.GetErrorString());
        REQUIRE(read != nullptr);
        REQUIRE(read->mNumMeshes == 3);
        for (unsigned c = 0; c < 2; ++c) {
            const ClothRange& cloth = scene.topology.cloths[c];
            const aiMesh& mesh = *read->mMeshes[c];
            const auto own = [&](const Points& all) {
                return Points(all.middleRows(cloth.first_vertex, cloth.vertex_count));
            };
            CHECK(mesh.mName.C_Str() == cloth.name);
            REQUIRE(static_cast<int>(mesh.mNumVertices) == cloth.vertex_count);
            REQUIRE(static_cast<int>(mesh.mNumFaces) == cloth.triangle_count);
            const Triangles triangles = scene.triangles_of(cloth);
            for (unsigned t = 0; t < mesh.mNumFaces; ++t)
                for (int k = 0; k < 3; ++k)
                    CHECK(static_cast<int>(mesh.mFaces[t].mIndices[k]) == triangles(t, k));
            check_points(mesh.mVertices, own(positions_of(scene, 2)));
            CHECK(mesh.HasNormals());
            REQUIRE(mesh.HasTextureCoords(0));
            for (int i = 0; i < cloth.vertex_count; ++i)  // assimp's v is upwards again
                CHECK(mesh.mTextureCoords[0][i].y ==
                      Approx(scene.uv(cloth.first_vertex + i, 1)).margin(float_error));
            REQUIRE(mesh.mNumAnimMeshes == 3);
            for (unsigned k = 0; k < 3; ++k)
                check_points(mesh.mAnimMeshes[k]->mVertices,
                             own(positions_of(scene, static_cast<int>(3 + k))));
        }
        aiColor4D color;
        REQUIRE(read->mMaterials[1]->Get("$clr.base", 0, 0, color) == aiReturn_SUCCESS);
        CHECK((color.r == 0.25f && color.g == 0.5f && color.b == 0.75f));

        REQUIRE(read->mNumAnimations == 1);
        const aiAnimation& animation = *read->mAnimations[0];
        REQUIRE(animation.mNumMorphMeshChannels == 2);
        const aiMeshMorphAnim& weights = *animation.mMorphMeshChannels[0];
        REQUIRE(weights.mNumKeys == 4);
        for (unsigned i = 0; i < 4; ++i) {
            // A glTF's times are floats; assimp makes milliseconds of them, as floats too.
            CHECK(weights.mKeys[i].mTime == static_cast<float>(scene.time(scene.frames[i])) * 1000.0f);
            for (unsigned k = 0; k < 3; ++k) CHECK(weights.mKeys[i].mWeights[k] == (k + 1 == i ? 1.0 : 0.0));
        }
        REQUIRE(animation.mNumChannels == 1);
        CHECK(animation.mChannels[0]->mNodeName.C_Str() == std::string("box"));
        CHECK(animation.mChannels[0]->mPositionKeys[3].mValue.x == Approx(2.5));
        CHECK(read->mNumCameras == 1);
    }
}
