// What a scene file is refused with: file, line, column, key and what would be right.

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "pipeline/scene_file/scene_text.h"
#include "support/temporary_folder.h"

using namespace cloth;
using namespace cloth::pipeline;
using Catch::Matchers::Contains;

TEST_CASE("errors name file, line, column, key and what would be right", "[scene_file]") {
    struct Case {
        std::string text, message;
    };
    const std::string penalty = "[simulation]\ncontact = \"penalty\"\n",
                      linear = penalty + "integrator = \"linearly_implicit_euler\"\n";
    const std::vector<Case> cases = {
        // what is not TOML
        {"version = 1\n[simulation\n", "s.toml:2:"},
        {"version = 1\nversion = 1\n", "s.toml:2:"},
        {"version = 1\nx = \"\\q\"\n", "s.toml:2:"},
        {"version = 1\nx = 99999999999999999999\n", "s.toml:2:"},
        // version
        {"", "s.toml:1:1: version: is missing; write version = 1"},
        {"version = 2\n", "s.toml:1:11: version: is 2; this program reads version 1"},
        {"version = \"1\"\n", "s.toml:1:11: version: is a string; must be a whole number"},
        // unknown keys
        {sheet("fabric = { densty = 1 }\n"),
         "s.toml:3:12: cloth[0].fabric.densty: unknown key; did you mean \"density\" [kg/m²]?"},
        {sheet("wibble = 1\n"), "s.toml:3:1: cloth[0].wibble: unknown key; known here: "},
        {sheet("[simulaton]\n"), "s.toml:3:2: simulaton: unknown key; did you mean \"simulation\"?"},
        {sheet("[simulation]\n  frame_rte = 1\n"),
         "s.toml:4:3: simulation.frame_rte: unknown key; did you mean "
         "\"frame_rate\" [1/s]?"},
        {sheet("[camera]\nzoom_in = 1\n"),
         "s.toml:4:1: camera.zoom_in: unknown key; known here: position, target"},
        // types
        {sheet("size = 1\n"), "s.toml:3:8: cloth[0].size: is a whole number; must be [x, y] [m]"},
        {sheet("size = [1, 2, 3]\n"), "s.toml:3:8: cloth[0].size: has 3 entries; must be [x, y] [m]"},
        {sheet("size = [1, \"a\"]\n"), "cloth[0].size: is a string; must be a number [m]"},
        {sheet("resolution = 20.5\n"), "cloth[0].resolution: is a number; must be a whole number or"},
        {sheet("resolution = 5000000000\n"), "is 5000000000; must be between -2147483648 and 2147483647"},
        {sheet("bump = true\n"), "cloth[0].bump: is a boolean; must be a number [m]"},
        {sheet("bump = \"high\"\n"), "cloth[0].bump: is a string; must be a number [m]"},
        {sheet("bump = 1979-05-27\n"), "cloth[0].bump: is a date or time; must be a number [m]"},
        {sheet("name = 3\n"), "cloth[0].name: is a whole number; must be a string"},
        {sheet("fabric = 3\n"),
         "s.toml:3:10: cloth[0].fabric: is a whole number; must be a fabric's name "
         "or a table"},
        {sheet("[[collider]]\nenabled = 1\n"),
         "collider[0].enabled: is a whole number; must be true or false"},
        {sheet("[[pin]]\nvertices = 3\n"), "pin[0].vertices: is a whole number; must be an array"},
        {sheet("[[pin]]\nbox = [[1, 2, 3]]\n"), "pin[0].box: has 1 entries; must be two entries [m]"},
        {sheet("[[drag]]\npath = [[1, 2]]\n"), "drag[0].path: has 2 entries; must be [time, x, y]"},
        {sheet("[[camera]]\n"), "camera: is an array; must be a table, [camera]"},
        {"version = 1\n[cloth]\n", "s.toml:2:1: cloth: is a table; must be a list of tables, [[cloth]]"},
        {"version = 1\ncloth = [1]\n", "cloth: is a whole number; must be a table, [[cloth]]"},
        // colours and sizes
        {sheet("color = \"red\"\n"),
         "cloth[0].color: is a string; must be \"#rrggbb\" or [red, green, blue]"},
        {sheet("color = [0, 0, 1.5]\n"), "cloth[0].color: is out of range; must be \"#rrggbb\""},
        {sheet("color = [0, 0]\n"), "cloth[0].color: must be \"#rrggbb\""},
        {sheet("[output]\nsize = \"640\"\n"),
         "output.size: is \"640\"; must be \"WIDTHxHEIGHT\" or [width, height]"},
        {sheet("[output]\nsize = \"99999999999x9\"\n"), "must be \"WIDTHxHEIGHT\" or [width, height]"},
        {sheet("[output]\nsize = 640\n"), "output.size: is a whole number; must be \"WIDTHxHEIGHT\""},
        {sheet("[output]\nsize = [0, 360]\n"), "output.size: is 0; must be 16 … 8192 pixel"},
        {sheet("[output]\nsize = \"640x10000\"\n"), "output.size: is 10000; must be 16 … 8192 pixel"},
        // numbers that are none
        {sheet("scale = 1e300\n"), "s.toml:3:9: cloth[0].scale: is 1e300; must be 1e-6 … 1000000"},
        {sheet("[simulation]\ngravity = [0, -1e300, 0]\n"),
         "s.toml:4:11: simulation.gravity: is -1e300; must be -10000 … 10000 m/s²"},
        {sheet("[[drag]]\npath = [[0, 1, 1], [1, 1e300, 1]]\n"),
         "s.toml:4:8: drag[0].path: is 1e300; must be -1000000 … 1000000"},
        {sheet("[[pin]]\nedge = \"top\"\npath = [{ time = 0, rotate = [0, 1e300, 0] }]\n"),
         "s.toml:5:30: pin[0].path[0].rotate: is 1e300; must be -1000000 … 1000000 degree"},
        {sheet("bump = nan\n"), "s.toml:3:8: cloth[0].bump: is not finite; must be a finite number [m]"},
        {sheet("translate = [0, inf, 0]\n"),
         "cloth[0].translate: is not finite; must be a finite number [m]"},
        {sheet("[camera]\nfield_of_view = -inf\n"), "camera.field_of_view: is not finite"},
        // words
        {sheet("diagonals = \"unifrom\"\n"),
         "s.toml:3:13: cloth[0].diagonals: is \"unifrom\"; did you mean \"uniform\"? (one of uniform, "
         "mirrored, alternating)"},
        {sheet("diagonals = \"zigzag-ish\"\n"),
         "is \"zigzag-ish\"; must be one of uniform, mirrored, alternating"},
        {sheet("[simulation]\nintegrator = \"implict_euler\"\n"), "did you mean \"implicit_euler\"?"},
        {sheet("[simulation]\nhessian = \"none at all\"\n"), "must be one of assignment, projected"},
        {sheet("[simulation]\ncontact = \"penality\"\n"), "did you mean \"penalty\"?"},
        {sheet("[[collider]]\nshape = \"spere\"\n"),
         "collider[0].shape: is \"spere\"; did you mean \"sphere\"?"},
        {sheet("[[event]]\naction = \"of\"\n"), "event[0].action: is \"of\"; did you mean"},
        {sheet("[[event]]\nintegrator = \"euler\"\n"),
         "s.toml:4:14: event[0].integrator: is \"euler\"; must be one of "
         "toggle, linearly_implicit_euler, implicit_euler, tr_bdf2, implicit_midpoint"},
        // ranges, most of them known to the simulation alone
        {sheet("[simulation]\ntime_step = 0\n"),
         "s.toml:4:13: simulation.time_step: is 0; must be 1e-9 … 1000 s"},
        {sheet("[simulation]\ntime_step = -0.01\n"), "simulation.time_step: is -0.01; must be 1e-9 … 1000 s"},
        {sheet("[simulation]\nsubsteps = 0\n"), "simulation.substeps: is 0; must be 1 … 1000000"},
        {sheet("[simulation]\nframe_rate = -1\n"),
         "simulation.frame_rate: is -1; must be 0.001 … 1000000 1/s"},
        {sheet("[simulation]\ntime_step = 0.1\nsubsteps = 2\n"),
         "s.toml:4:13: simulation.time_step: stands beside simulation.substeps; give one of the two"},
        {sheet("size = [0, 1]\n"), "s.toml:3:8: cloth[0].size: is 0; must be 1e-6 … 1000000 m"},
        {sheet("resolution = 1\n"), "s.toml:3:14: cloth[0].resolution: is 1; must be 2 … 4096 vertices"},
        {sheet("resolution = [-4, 3]\n"), "cloth[0].resolution: is -4; must be 2 … 4096 vertices"},
        {sheet("scale = 0\n"), "cloth[0].scale: is 0; must be 1e-6 … 1000000"},
        {sheet("fabric.density = -1\n"),
         "s.toml:3:18: cloth[0].fabric.density: is -1; must be 1e-6 … 1000000 kg/m²"},
        {sheet("fabric.mu = 1\n"), "cloth[0].fabric.mu: mu and lambda are given together or not at all"},
        {sheet("fabric = { mu = 1, lambda = 1, young_modulus = 2 }\n"),
         "cloth[0].fabric.young_modulus: stands beside mu and lambda"},
        {sheet(penalty + "[[collider]]\nshape = \"box\"\n"),
         "collider[0].shape: needs contact = \"barrier\""},
        {sheet(penalty + "[[collider]]\nspin = [0, 90, 0]\n"),
         "collider[0].spin: needs contact = \"barrier\""},
        {sheet("[[collider]]\nmesh = \"a.obj\"\n"), "collider[0].mesh: belongs to shape = \"mesh\""},
        {sheet("[[collider]]\nshape = \"mesh\"\n"), "collider[0].mesh: is missing"},
        {sheet("[simulation]\nintegrator = \"implicit_midpoint\"\n"),
         "simulation.contact: is \"barrier\", which needs integrator = \"implicit_euler\" or"},
        {sheet("[simulation]\ncontact_activation = 0\n"),
         "simulation.contact_activation: is 0; must be 1e-9 … 1000 m"},
        {sheet("contact_thickness = 0\n"), "cloth[0].contact_thickness: is 0; must be 1e-9 … 1000 m"},
        {sheet("[[collider]]\nradius = -1\n"), "collider[0].radius: is -1; must be 1e-6 … 1000000 m"},
        {sheet("[[collider]]\ncontact_radius = 0.3\ncontact_offset = 0.1\n"),
         "collider[0].contact_radius: stands beside contact_offset; give one of the two"},
        {sheet("[[collider]]\nshape = \"plane\"\nnormal = [0, 0, 0]\n"), "collider[0].normal: is zero"},
        {sheet("[camera]\nfield_of_view = 180\n"),
         "s.toml:4:17: camera.field_of_view: is 180; must be 1 … 160 degree"},
        {sheet("[camera]\ntarget = [0, 0, 1]\nposition = [0, 0, 1]\n"),
         "s.toml:4:10: camera.target: is where the camera"},
        {sheet("[camera]\nup = [0, 0, 0]\n"), "camera.up: points along the view"},
        {sheet("[camera]\nposition = [0, 1, 0]\n"), "camera.up: points along the view"},
        {sheet("[[light]]\ndirection = [0, 0, 0]\n"), "s.toml:4:13: light[0].direction: is zero"},
        {sheet("[light]\nintensity = -1\n"), "light[0].intensity: is -1; must be 0 … "},
        {sheet("[[light]]\n[[light]]\n"), "s.toml:4:1: light[1]: there is one light"},
        {sheet("roughness = 1.5\n"), "s.toml:3:13: cloth[0].roughness: is 1.5; must be 0 … 1"},
        {sheet("[[collider]]\nspecular = -0.5\n"), "collider[0].specular: is -0.5; must be 0 … 1"},
        {sheet("sheen = -1\n"), "cloth[0].sheen: is -1; must be 0 … 10"},
        {sheet("pattern = \"tartn\"\n"),
         "s.toml:3:11: cloth[0].pattern: is \"tartn\"; did you mean \"tartan\"?"},
        {sheet("pattern_scale = 0\n"), "cloth[0].pattern_scale: is 0; must be 0.0001 … 1000 m"},
        {sheet("pattern_colors = []\n"),
         "cloth[0].pattern_colors: has 0 entries; must be one to three colours"},
        {sheet("pattern_colors = [\"red\"]\n"), "cloth[0].pattern_colors: is a string; must be \"#rrggbb\""},
        {sheet("texture = \"none.png\"\n"), "s.toml:3:11: cloth[0].texture: "},
        {sheet("texture = \"a.png\"\npattern = \"dots\"\n"),
         "cloth[0].pattern: stands beside texture, which takes its place; give one or the other"},
        {sheet("weave = -1\n"), "cloth[0].weave: is -1; must be 0 … 1 m"},
        {sheet("weave_depth = 3\n"), "cloth[0].weave_depth: is 3; must be 0 … 2"},
        {sheet("hem = 1\n"), "cloth[0].hem: is 1; must be 0 … 0.1 m"},
        {sheet("[[light]]\nangle = 90\n"), "light[0].angle: is 90; must be 0 … 45 degree"},
        {sheet("[background]\nexposure = 0\n"), "background.exposure: is 0; must be "},
        {sheet("[output]\nframes = 0\n"), "s.toml:4:10: output.frames: is 0; must be 1 … "},
        {sheet("[output]\nquality = 52\n"), "output.quality: is 52; must be 0 … 51"},
        {sheet("[output]\nplayback_rate = 0\n"), "output.playback_rate: is 0; must be 0.01 … 1000 1/s"},
        {sheet("[expect]\nframes = [-1]\n"), "s.toml:4:10: expect.frames: is -1; must be 0 … "},
        {sheet("[expect]\nstate_tolerance = 0\n"), "expect.state_tolerance: is 0; must be "},
        // references
        {"version = 1\n", "cloth: the scene has no [[cloth]]"},
        {sheet("name = \"a\"\n[[cloth]]\nname = \"a\"\n"),
         "s.toml:5:8: cloth[1].name: \"a\" is taken; names must differ"},
        {sheet("[[collider]]\nname = \"a\"\n[[collider]]\nname = \"a\"\n"),
         "collider[1].name: \"a\" is taken"},
        {sheet("[[event]]\ncollider = \"ball\"\n"),
         "s.toml:4:12: event[0].collider: there is no collider \"ball\"; the scene has none"},
        {sheet("[[collider]]\nname = \"ball\"\n[[event]]\ncollider = \"bal\"\n"),
         "event[0].collider: there is no collider \"bal\"; did you mean \"ball\"?"},
        {sheet("[[collider]]\nname = \"ball\"\n[[event]]\ncollider = \"somewhere\"\n"), "known: ball"},
        {sheet("[[event]]\naction = \"on\"\n"),
         "event[0].action: acts on a collider; name one with collider"},
        {sheet("[[event]]\ntime = 1\n"), "s.toml:3:1: event[0]: give either a collider or an integrator"},
        {sheet("[[event]]\ntime = -1\nintegrator = \"toggle\"\n"), "event[0].time: is -1; must be 0 … 1e9 s"},
        {sheet("[[pin]]\ncloth = \"other\"\nnearest = [0, 0, 0]\n"),
         "pin[0].cloth: there is no cloth \"other\""},
        {sheet("[[pin]]\ncloth = 1\nnearest = [0, 0, 0]\n"),
         "pin[0].cloth: is 1; the scene has 1 [[cloth]], counted from 0"},
        {sheet("[[pin]]\ncloth = -1\nnearest = [0, 0, 0]\n"),
         "pin[0].cloth: is -1; the scene has 1 [[cloth]]"},
        {sheet("[[pin]]\ncloth = 0.5\nnearest = [0, 0, 0]\n"),
         "pin[0].cloth: is a number; must be a cloth's name or its index"},
        {sheet("[[pin]]\n"), "s.toml:3:1: pin[0]: give exactly one of vertices, box, nearest, greatest"},
        {sheet("[[pin]]\nvertices = []\n"), "pin[0].vertices: is empty"},
        {sheet("[[pin]]\nvertices = [400]\n"),
         "s.toml:4:12: pin[0].vertices: vertex 400 does not exist; the cloth has "
         "vertices 0 … 399"},
        {sheet("[[pin]]\nbox = [[5, 5, 5], [6, 6, 6]]\n"), "s.toml:3:1: pin[0]: selects no vertex"},
        {sheet("[[pin]]\ngreatest = \"w\"\n"),
         "pin[0].greatest: is \"w\"; must be one of x, y, z, -x, -y, -z"},
        {sheet("[[pin]]\nedge = \"up\"\n"),
         "s.toml:4:8: pin[0].edge: is \"up\"; must be one of left, right, bottom, top"},
        {sheet("[[pin]]\nedge = \"top\"\ngreatest = \"y\"\n"), "pin[0]: give exactly one of"},
        {sheet("[[pin]]\nedge = \"top\"\nuntil = 0\n"),
         "s.toml:5:9: pin[0].until: is 0; must be 1e-9 … 1e9 s"},
        {sheet("[[pin]]\nedge = \"top\"\npath = [1]\n"),
         "s.toml:5:9: pin[0].path[0]: is a whole number; must be { time, translate, rotate }"},
        {sheet("[[pin]]\nedge = \"top\"\npath = [{ time = 0 }, { translate = [0, 1, 0] }]\n"),
         "s.toml:5:23: pin[0].path[1]: has no time [s]"},
        {sheet("[[pin]]\nedge = \"top\"\npath = [{ time = 0, tranlate = [0, 1, 0] }]\n"),
         "s.toml:5:21: pin[0].path[0].tranlate: unknown key; did you mean \"translate\" [m]?"},
        {sheet("[[pin]]\nedge = \"top\"\npath = [{ time = 0, rotate = 90 }]\n"),
         "s.toml:5:30: pin[0].path[0].rotate: is a whole number; must be [x, y, z] [degree]"},
        {sheet("[[pin]]\nedge = \"top\"\npath = [{ time = 1 }, { time = 1 }]\n"),
         "s.toml:5:8: pin[0].path: has times that do not increase"},
        {sheet("[[pin]]\nedge = \"top\"\npath = [{ time = -1 }]\n"),
         "pin[0].path[0].time: is -1; must be 0 … 1e9 s"},
        // seams
        {sheet("[[seam]]\nfirst = { edge = \"left\" }\n"),
         "s.toml:3:1: seam[0]: has no second; give the vertices of both sides"},
        {sheet("[[seam]]\nfirst = \"left\"\n"),
         "s.toml:4:9: seam[0].first: is a string; must be a table such as { edge = \"left\" }"},
        {sheet("[[seam]]\nfirst = { egde = \"left\" }\n"),
         "s.toml:4:11: seam[0].first.egde: unknown key; did you mean \"edge\"?"},
        {sheet("[[seam]]\nfrist = { edge = \"left\" }\n"),
         "s.toml:4:1: seam[0].frist: unknown key; did you mean \"first\"?"},
        {sheet("[[seam]]\nfirst = { edge = \"left\", cloth = \"shed\" }\nsecond = { edge = \"left\" }\n"),
         "s.toml:4:34: seam[0].first.cloth: there is no cloth \"shed\""},
        {sheet("[[seam]]\nfirst = { edge = \"left\" }\nsecond = { edge = \"left\", cloth = 1 }\n"),
         "seam[0].second.cloth: is 1; the scene has 1 [[cloth]]"},
        {sheet("[[seam]]\nfirst = { edge = \"left\" }\nsecond = { vertices = [] }\n"),
         "seam[0].second.vertices: is empty"},
        {sheet("[[seam]]\nfirst = { edge = \"left\" }\nsecond = { vertices = [1, 2, 3] }\n"),
         "s.toml:5:10: seam[0].second: has 3 vertices, the first side 20; a seam sews one to one"},
        {sheet("[[seam]]\nfirst = {}\nsecond = { edge = \"left\" }\n"),
         "s.toml:4:9: seam[0].first: give exactly one of vertices, box, nearest, greatest, edge"},
        {sheet("[[seam]]\nfirst = { edge = \"left\" }\nsecond = { edge = \"right\" }\nclose_time = 0\n"),
         "s.toml:6:14: seam[0].close_time: is 0; must be 1e-9 … 1e9 s"},
        // air
        {sheet("[air]\nlift = 0.5\n"), "s.toml:4:8: air.lift: is 0.5; must be at most the drag, 0"},
        {sheet("[air]\ndensity = 0\n"), "air.density: is 0; must be 1e-6 … 1000000 kg/m³"},
        {sheet("[air]\nseed = -1\n"), "s.toml:4:8: air.seed: is -1; must be 0 … 4294967295"},
        {sheet("[air]\nseed = 0.5\n"), "air.seed: is a number; must be a whole number"},
        {sheet("[air]\nwinds = [1, 0, 0]\n"), "air.winds: unknown key; did you mean \"wind\" [m/s]?"},
        {sheet("[[air]]\n"), "air: is an array; must be a table, [air]"},
        // fabrics
        {sheet("fabric = \"coton\"\n"),
         "s.toml:3:10: cloth[0].fabric: there is no fabric \"coton\"; did you mean \"cotton\"? known: "
         "cotton, "
         "denim, jersey, "},
        {sheet("fabric = \"quite another\"\n"), "there is no fabric \"quite another\"; known: cotton, "},
        {sheet("fabric = { base = \"wol\" }\n"),
         "s.toml:3:19: cloth[0].fabric.base: there is no fabric \"wol\"; did you mean \"wool\"?"},
        {sheet("fabric = { base = 3 }\n"),
         "s.toml:3:19: cloth[0].fabric.base: is a whole number; must be a fabric's name"},
        {sheet("fabric = { bse = \"wool\" }\n"),
         "s.toml:3:12: cloth[0].fabric.bse: unknown key; did you mean \"base\"?"},
        {sheet("fabric = \"cotton\"\n" + linear),
         "cloth[0].fabric.strain_limit: needs integrator = \"implicit_euler\""},
        {sheet("fabric = { base = \"denim\", poisson_ratio = 1.5, strain_limit = 0 }\n"),
         "cloth[0].fabric.poisson_ratio: is 1.5; must lie between -1 and 1"},
        {sheet("fabric = { base = \"cotton\", density = -0.2, strain_limit = 0 }\n"),
         "cloth[0].fabric.density: is -0.2; must be 1e-6 … 1000000 kg/m²"},
        {sheet("fabric = { base = \"cotton\", mu = 1, lambda = 1, young_modulus = 1, strain_limit = 0 }\n"),
         "cloth[0].fabric.young_modulus: stands beside mu and lambda"},
        {sheet("fabric.membrane = \"neo_hokean\"\n"),
         "s.toml:3:19: cloth[0].fabric.membrane: is \"neo_hokean\"; did you mean \"neo_hookean\"?"},
        {sheet("fabric.bending_model = \"plates\"\n"), "must be one of quadratic, hinges"},
        {sheet("fabric.young_weft = 1e5\n"),
         "s.toml:3:21: cloth[0].fabric.young_weft: needs membrane = \"st_venant_kirchhoff\""},
        {sheet("fabric = { strain_limit = 0.9 }\n"),
         "s.toml:3:27: cloth[0].fabric.strain_limit: is 0.9; must be greater than 1 and at most 1000, a "
         "stretch such as 1.05"},
        {sheet("fabric.strain_limit = 1.05\n" + linear),
         "cloth[0].fabric.strain_limit: needs integrator = \"implicit_euler\" or \"tr_bdf2\""},
        {sheet("fabric.yield_curvature = 100\n"),
         "cloth[0].fabric.yield_curvature: needs bending_model = \"hinges\""},
        {sheet("fabric.friction = -0.1\n"), "cloth[0].fabric.friction: is -0.1; must be 0 … 1000"},
        {sheet("warp = [0, 0, 0]\n"), "s.toml:3:8: cloth[0].warp: is zero; must point along the rest shape"},
        {sheet("[simulation]\nretries = -1\n"), "simulation.retries: is -1; must be 0 … 20"},
        {sheet("[[drag]]\npath = [[0, 1, 1]]\n"), "s.toml:4:8: drag[0].path: needs at least two keys"},
        {sheet("[[drag]]\npath = [[1, 1, 1], [0.5, 1, 1]]\n"),
         "drag[0].path: has times that do not increase"},
        {sheet("[[drag]]\npath = [[0, 1, 1], [1, 1, 1]]\nviewport = [0, 1]\n"),
         "drag[0].viewport: is 0; must be 1 … 1000000 pixel"},
        // meshes
        {sheet("mesh = \"none.obj\"\n"), "s.toml:3:8: cloth[0].mesh: "},
        {sheet("units = \"cm\"\n"),
         "s.toml:3:9: cloth[0].units: belongs to a mesh or pose; sizes in a scene are in metres"},
        {sheet("mesh = \"none.obj\"\nunits = \"km\"\n"),
         "s.toml:4:9: cloth[0].units: is \"km\"; did you mean \"m\"? (one of m, cm, mm, in, ft)"},
        {sheet("weld = false\n"),
         "s.toml:3:8: cloth[0].weld: belongs to a mesh; other shapes have no doubled vertices"},
        {sheet("[[collider]]\nunits = \"cm\"\n"), "collider[0].units: belongs to shape = \"mesh\""},
        {sheet("mesh = \"none.obj\"\nresolution = 3\n"),
         "s.toml:4:14: cloth[0].resolution: belongs to a grid, but the cloth has a mesh; give one of the "
         "two"},
        {sheet("pose = \"none.obj\"\n"), "s.toml:3:8: cloth[0].pose: "},
        {sheet("radius = 0.15\nresolution = 3\n"),
         "s.toml:4:14: cloth[0].resolution: belongs to a grid, but the cloth has a radius; give one of the "
         "two"},
        {sheet("rings = 4\n"), "s.toml:3:9: cloth[0].rings: belongs to a disc; give its radius too"},
        {sheet("radius = 0.15\nrings = 0\n"), "s.toml:4:9: cloth[0].rings: is 0; must be 1 … 1000"},
        {sheet("radius = -1\n"), "cloth[0].radius: is -1; must be 1e-6 … 1000000 m"},
        {sheet("radius = 0.15\nmesh = \"none.obj\"\n"),
         "s.toml:3:10: cloth[0].radius: belongs to a disc, but the cloth has a mesh; give one of the two"},
        {sheet("radius = 0.15\n[[pin]]\nedge = \"top\"\n"), "names a grid's edge; this cloth is no grid"},
    };
    for (const Case& c : cases) {
        INFO(c.text);
        const std::string message = refusal(c.text);
        CHECK_THAT(message, Contains(c.message));
        CHECK_THAT(message, Catch::StartsWith("s.toml:"));
    }
}

TEST_CASE("a mesh's fault is told with the scene's place and the mesh's line", "[scene_file]") {
    const TemporaryFolder folder;
    spit(folder / "cross.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 3 2 4\n");
    spit(folder / "flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    spit(folder / "good.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    spit(folder / "four.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 1\n");
    const auto told = [&](const std::string& keys) {
        return refusal_of([&] { parse_scene(sheet(keys), "s.toml", folder.path()); });
    };
    CHECK_THAT(told("mesh = \"none.obj\"\n"),
               Contains("s.toml:3:8: cloth[0].mesh: ") && Contains("none.obj: there is no such file"));
    CHECK_THAT(told("mesh = \"cross.obj\"\n"),
               Contains("s.toml:3:8: cloth[0].mesh: ") && Contains("cross.obj:5: face 0"));
    CHECK_THAT(told("mesh = \"flat.obj\"\n"),
               Contains("s.toml:3:8: cloth[0].mesh: triangle 0") && Contains("degenerate"));
    CHECK_THAT(told("mesh = \".\"\n"), Contains("is a folder"));
    CHECK_THAT(told("mesh = \"good.obj\"\npose = \"four.obj\"\n"),
               Contains("s.toml:4:8: cloth[0].pose: has 4 vertices; the rest shape has 3"));
    CHECK_THAT(told("mesh = \"good.obj\"\n[[pin]]\nedge = \"top\"\n"),
               Contains("s.toml:5:8: pin[0].edge: names a grid's edge; this cloth is no grid"));
    CHECK(told("mesh = \"good.obj\"\n") == "");
}
