#include "sim/scene/fabrics.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace cloth {
namespace {

struct Number {
    double value;
    const char* source;
};

/// What is known of a fabric; stiffnesses per width.
struct Data {
    const char *name, *description;
    MembraneKind membrane;
    Number density;                             // kg/m²
    Number thickness;                           // m
    Number stretch;                             // N/m, along the warp
    std::optional<Number> stretch_weft, shear;  // N/m
    Number poisson_ratio;
    Number strain_limit;
    BendingKind bending_model;
    Number bending, bending_weft, bending_bias;  // N m
    std::optional<Number> yield_curvature;       // 1/m
    Number membrane_damping, bending_damping;    // s
    Number friction;
};

// Sources that serve several fabrics.
constexpr auto penava = "Penava et al. 2014, as tabulated by Li et al. 2021 (Codimensional IPC)";
constexpr auto bias_of_many =
    "harmonic mean of warp and weft; the 251 fabrics of Feng et al. 2022 have 1.03 of it in the median";
constexpr auto wang_denim = "Wang et al. 2011, unstretched 11 oz denim with 1 % elastane";
constexpr auto wang_interlock = "Wang et al. 2011, unstretched cotton-polyester interlock, 60/40";
constexpr auto wang_twill = "Wang et al. 2011, unstretched cotton-polyester trouser cloth, 65/35";
constexpr auto wang_polyester = "Wang et al. 2011, unstretched polyester tablecloth";
constexpr auto suitings = "mean of men's winter suitings (Kawabata 1980, KN-101), as commonly quoted";
constexpr auto soft_friction =
    "typical range 0.15-0.3 of smooth filament weaves, steel (KES-F) to cloth; chosen";
constexpr auto rough_friction = "typical range 0.3-0.6 of spun weaves on one another; chosen";

const Data table[] = {
    {"cotton",
     "plain-woven shirting",
     MembraneKind::st_venant_kirchhoff,
     {0.150, penava},
     {0.318e-3, penava},
     {2017.0, wang_twill},
     Number{2035.0, wang_twill},
     Number{56.0, "typical KES-F range of shirtings 0.5-2 gf/(cm degree), 28-112 N/m; 1 taken"},
     {0.24, penava},
     {1.05, "typical KES-F extension of shirtings at 490 N/m, 2-7 %; 5 % taken"},
     BendingKind::quadratic,
     {15e-6,
      "Feng et al. 2022: half of the 22 fabrics of 0.13-0.17 kg/m² have 7-18 µN m; chosen there for a Cusick "
      "drape of 60-76 % (Gan et al. 1991: 68.4 %)"},
     {10e-6, "as along the warp; Feng et al. 2022: weft 0.68 of warp in the median"},
     {12e-6, bias_of_many},
     std::nullopt,
     {0.015, "typical KES-F resilience RT of 55 %: η = 0.29"},
     {0.02, "typical KES-F hysteresis 2HB/B of 0.6 /cm: η = 0.38"},
     {0.35, rough_friction}},
    {"denim",
     "11 oz cotton twill",
     MembraneKind::st_venant_kirchhoff,
     {0.324, wang_denim},
     {0.6e-3, "typical range 0.5-0.7 mm of 11 oz denim; middle taken"},
     {1014.0, wang_denim},
     Number{205.0, wang_denim},
     Number{53.0,
            "Wang et al. 2011, 53-84 N/m; KES-F of six denims, Journal of Textiles 2016 4614168: 84-191 N/m"},
     {0.25, "typical of twills, lower than of plain weaves (Hursa et al. 2009: 0.2-0.5); chosen"},
     {1.055, "KES-F extension of six denims at 490 N/m, Journal of Textiles 2016 4614168: 4.7-5.7 %"},
     BendingKind::quadratic,
     {120e-6,
      "Feng et al. 2022: five warp-stiff fabrics of 0.31-0.37 kg/m² have 98-189 µN m; chosen there for a "
      "Cusick "
      "drape of 70-90 % (Wang et al. 2011: 60-120)"},
     {40e-6, "Feng et al. 2022: the same five have 16-51 µN m"},
     {52e-6, "Feng et al. 2022: the same five have 36-66 µN m"},
     std::nullopt,
     {0.015, "KES-F resilience RT of six denims, Journal of Textiles 2016 4614168: 54 %, η = 0.29"},
     {0.03, "KES-F hysteresis of six denims, Journal of Textiles 2016 4614168: 2HB/B = 0.9 /cm, η = 0.57"},
     {0.5, rough_friction}},
    {"jersey",
     "cotton-polyester T-shirt knit",
     MembraneKind::st_venant_kirchhoff,
     {0.187, wang_interlock},
     {0.7e-3, "typical range 0.5-0.9 mm of T-shirt knits; middle taken"},
     {34.5, wang_interlock},
     Number{16.6, wang_interlock},
     Number{36.9, wang_interlock},
     {0.3, "typical range 0.2-0.5 of weft knits; chosen"},
     {1.4, "typical extension of T-shirt knits at 490 N/m, 20-60 %; middle taken"},
     BendingKind::quadratic,
     {4e-6,
      "typical KES-F range of T-shirt knits 0.01-0.05 gf cm²/cm, 1-5 µN m; chosen (Wang et al. 2011 give "
      "7-39)"},
     {2.5e-6, "as along the wales"},
     {3.1e-6, bias_of_many},
     std::nullopt,
     {0.02, "typical KES-F resilience RT of knits of 40 %: η = 0.38"},
     {0.03, "typical KES-F hysteresis 2HB/B of knits of 1 /cm: η = 0.64"},
     {0.4, rough_friction}},
    {"leather",
     "sheep garment leather",
     MembraneKind::corotational,
     {0.48, "0.8 mm of typically 600 kg/m³"},
     {0.8e-3, "Memon et al. 2021: 0.64-0.96 mm; middle taken"},
     {4e3,
      "chosen: E = 5 MPa for the soft start of the curve, with which the drape comes out as Memon et al. "
      "2021 "
      "measured, 47-70 % (Efendioglu 2025, ISO 3376: 77 MPa in the mean up to break)"},
     std::nullopt,
     std::nullopt,
     {0.4, "typical range 0.3-0.5; middle taken"},
     {1.1, "typical extension of garment leather under wear loads, 5-15 %; middle taken"},
     BendingKind::quadratic,
     {16e-6, "Memon et al. 2021: 9.2-22, read as µN m; middle taken"},
     {16e-6, "as along the back"},
     {16e-6, "isotropic"},
     std::nullopt,
     {0.015, "no measurement found; as of cotton"},
     {0.02, "no measurement found; as of cotton"},
     {0.5, "typical range 0.4-0.6 of leather on cloth; middle taken"}},
    {"paper",
     "copy paper; folds stay",
     MembraneKind::corotational,
     {0.080, "nominal, ISO 536 grade 80 g/m²"},
     {0.1e-3, "typical range 0.09-0.11 mm of 80 g/m² copy paper"},
     {4e5, "typical range of E 3-5 GPa; 4 GPa taken"},
     std::nullopt,
     std::nullopt,
     {0.3, "typical range 0.15-0.4; middle taken"},
     {1.01, "breaks at 1.5-3 %, leaves the elastic range before 1 %"},
     BendingKind::hinges,
     {450e-6, "E h³/12/(1-ν²) with E = 4.9 GPa along the machine direction; machine : cross about 2 : 1"},
     {225e-6, "half of the machine direction's"},
     {300e-6, "harmonic mean of both directions"},
     Number{100.0,
            "surface strain κ h/2 = 0.5 %, where stress-strain curves leave the straight line; chosen"},
     {0.002, "typical loss factor of paper 0.03-0.05: η = 0.04"},
     {0.002, "typical loss factor of paper 0.03-0.05: η = 0.04"},
     {0.4, "typical range 0.3-0.6 of paper on paper; chosen"}},
    {"polyester",
     "plain-woven dress cloth of filament yarn",
     MembraneKind::st_venant_kirchhoff,
     {0.165, penava},
     {0.252e-3, penava},
     {2002.0, wang_polyester},
     Number{2027.0, wang_polyester},
     Number{19.0, wang_polyester},
     {0.38, penava},
     {1.05, "typical KES-F extension of polyester weaves at 490 N/m, 3-7 %; 5 % taken"},
     BendingKind::quadratic,
     {9e-6,
      "Feng et al. 2022: the lower quarter of the 34 fabrics of 0.15-0.2 kg/m² ends at 7 µN m; chosen near "
      "it"},
     {6e-6, "as along the warp; Feng et al. 2022: weft 0.68 of warp in the median"},
     {7.2e-6, bias_of_many},
     std::nullopt,
     {0.01, "typical KES-F resilience RT of 65 %: η = 0.22"},
     {0.01, "typical KES-F hysteresis 2HB/B of filament weaves of 0.35 /cm: η = 0.22"},
     {0.25, soft_friction}},
    {"ripstop_nylon",
     "calendered parachute cloth",
     MembraneKind::st_venant_kirchhoff,
     {0.040, "MIL-C-44378 type I, 1.17 oz/yd²"},
     {0.076e-3, "MIL-C-44378 type I, 0.003 in"},
     {15e3,
      "a third of the 43 kN/m (0.43 GPa, 0.1 mm) common in simulations of inflated canopies, since crimp "
      "comes out "
      "first; chosen"},
     Number{15e3, "as along the warp"},
     Number{110.0, "typical KES-F range of tight filament weaves 1-3 gf/(cm degree); 2 taken"},
     {0.14, "common in simulations of canopies"},
     {1.04, "typical KES-F extension of filament nylon at 490 N/m, 2-5 %; chosen"},
     BendingKind::quadratic,
     {6e-6,
      "Feng et al. 2022: stiff light fabrics of 0.02-0.05 kg/m² have 9-24 µN m, soft ones 1-3; chosen "
      "between"},
     {5e-6, "as along the warp"},
     {5.5e-6, bias_of_many},
     std::nullopt,
     {0.01, "typical KES-F resilience RT of 65 %: η = 0.22"},
     {0.01, "typical KES-F hysteresis 2HB/B of filament weaves of 0.35 /cm: η = 0.22"},
     {0.25, soft_friction}},
    {"silk",
     "crepe-backed satin, 19 momme",
     MembraneKind::st_venant_kirchhoff,
     {0.082, "nominal, 19 momme of 4.31 g/m²"},
     {0.2e-3, "typical range 0.15-0.25 mm of 19 momme silk; middle taken"},
     {1200.0, "typical KES-F curves of dress silks, extension 2-4 % at 490 N/m, secant at 5 N/m; chosen"},
     Number{600.0,
            "typical KES-F curves of dress silks, extension 4-8 % at 490 N/m, secant at 5 N/m; chosen"},
     Number{20.0, "typical KES-F range of dress silks 0.2-0.5 gf/(cm degree), 11-28 N/m; middle taken"},
     {0.3, "typical range 0.2-0.5 of weaves (Hursa et al. 2009); chosen"},
     {1.06, "typical KES-F extension of dress silks at 490 N/m, 3-8 %; middle taken"},
     BendingKind::quadratic,
     {1.8e-6,
      "typical KES-F range of dress silks 0.015-0.05 gf cm²/cm, 1.5-5 µN m; chosen there for a Cusick drape "
      "of "
      "20-40 % (Matsudaira and Yang 2003)"},
     {1.3e-6, "as along the warp; Feng et al. 2022: weft 0.68 of warp in the median"},
     {1.5e-6, bias_of_many},
     std::nullopt,
     {0.01, "typical KES-F resilience RT of 65 %: η = 0.22"},
     {0.01, "typical KES-F hysteresis 2HB/B of silks of 0.3 /cm: η = 0.19"},
     {0.2, soft_friction}},
    {"wool",
     "worsted winter suiting",
     MembraneKind::st_venant_kirchhoff,
     {0.264, suitings},
     {0.746e-3, suitings},
     {610.0,
      "Kawabata 1980 (KN-101), mean of warp and weft: extension 6.0 % at 490 N/m, LT 0.61; secant at 5 N/m"},
     Number{610.0, "as along the warp; KN-101 gives the mean of both"},
     Number{54.0, "Kawabata 1980 (KN-101): 0.97 gf/(cm degree)"},
     {0.28, penava},
     {1.06, "Kawabata 1980 (KN-101): extension 6.0 % at 490 N/m"},
     BendingKind::quadratic,
     {15e-6, "Kawabata 1980 (KN-101): 0.136 gf cm²/cm, 13.3 µN m, in the mean of warp and weft"},
     {11.6e-6, "Kawabata 1980 (KN-101), as along the warp"},
     {13e-6, bias_of_many},
     std::nullopt,
     {0.013, "Kawabata 1980 (KN-101): resilience RT 62 %, η = 0.24"},
     {0.015, "Kawabata 1980 (KN-101): 2HB/B = 0.46 /cm, η = 0.29"},
     {0.4, rough_friction}},
};

NamedFabric make(const Data& d) {
    NamedFabric named;
    named.description = d.description;
    Fabric& f = named.fabric;
    f.name = d.name;
    f.membrane = d.membrane;
    f.bending_model = d.bending_model;
    const auto add = [&](const char* key, const char* unit, const Number& n, double value) {
        named.values.push_back({key, unit, value, n.source});
        return value;
    };
    const double h = d.thickness.value;
    f.density = add("density", "kg/m²", d.density, d.density.value);
    f.thickness = add("thickness", "m", d.thickness, h);
    f.young_modulus = add("young_modulus", "Pa", d.stretch, d.stretch.value / h);
    if (d.stretch_weft) f.young_weft = add("young_weft", "Pa", *d.stretch_weft, d.stretch_weft->value / h);
    if (d.shear) f.shear_modulus = add("shear_modulus", "Pa", *d.shear, d.shear->value / h);
    f.poisson_ratio = add("poisson_ratio", "", d.poisson_ratio, d.poisson_ratio.value);
    f.strain_limit = add("strain_limit", "", d.strain_limit, d.strain_limit.value);
    f.bending = add("bending", "N m", d.bending, d.bending.value);
    f.bending_weft = add("bending_weft", "N m", d.bending_weft, d.bending_weft.value);
    f.bending_bias = add("bending_bias", "N m", d.bending_bias, d.bending_bias.value);
    if (d.yield_curvature)
        f.yield_curvature = add("yield_curvature", "1/m", *d.yield_curvature, d.yield_curvature->value);
    f.membrane_damping = add("membrane_damping", "s", d.membrane_damping, d.membrane_damping.value);
    f.bending_damping = add("bending_damping", "s", d.bending_damping, d.bending_damping.value);
    f.friction = add("friction", "", d.friction, d.friction.value);
    return named;
}

}  // namespace

const std::vector<NamedFabric>& named_fabrics() {
    static const std::vector<NamedFabric> fabrics = [] {
        std::vector<NamedFabric> list;
        for (const Data& d : table) list.push_back(make(d));
        return list;
    }();
    return fabrics;
}

Fabric default_fabric() {
    return find_fabric("cotton")->fabric;
}

const NamedFabric* find_fabric(const std::string& name) {
    const auto& fabrics = named_fabrics();
    const auto found = std::find_if(fabrics.begin(), fabrics.end(),
                                    [&](const NamedFabric& f) { return f.fabric.name == name; });
    return found == fabrics.end() ? nullptr : &*found;
}

}  // namespace cloth
