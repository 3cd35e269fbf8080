// Scene files of sheets and planes: what is read, sampled, planned, written and refused.
#include "tests/scene/parse.h"
#include "tests/sheets/sheets.h"

#include "engine/plan/plan.h"
#include "engine/scene/mesh.h"
#include "engine/scene/scene_json.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <fstream>

namespace pliant::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

std::string scene_with(const std::string& simulation, const std::string& material, const std::string& body) {
  return "[simulation]\nspacing = 0.1\n" + simulation + "\n[materials.m]\n" + material +
         "\n[[body]]\nmaterial = \"m\"\n" + body + "\n";
}
const std::string a_sheet = "shape = { sheet = [1, 0.5] }\nthickness = 0.01";
const std::string a_box = "shape = { box = [1, 1, 1] }";

TEST(SheetScenes, AreReadAndWritten) {
  const Scene scene = parsed(
      scene_with("horizon = 1.74\ninfluence = \"increasing\"", "poisson = 0.8", a_sheet + "\nhorizon = 3.1"));
  EXPECT_EQ(scene.bodies[0].shape.kind, Shape::Kind::sheet);
  EXPECT_EQ(scene.bodies[0].thickness, 0.01);
  EXPECT_EQ(scene.bodies[0].horizon, 3.1);
  const auto json = scene_to_json(scene);
  EXPECT_EQ(json["body"][0]["shape"]["sheet"], nlohmann::json({1.0, 0.5}));
  EXPECT_EQ(json["body"][0]["thickness"], 0.01);
  EXPECT_EQ(json["simulation"]["influence"], "increasing");
  EXPECT_FALSE(json["simulation"].contains("weight_exponent"));
  const Model model = assemble(scene);
  EXPECT_EQ(model.count(), 50u);
  EXPECT_NEAR(model.volume[7], 1e-4, 1e-15);
  EXPECT_EQ(model.constants.size(), 2u);
  EXPECT_EQ(typed_material(scene, model, 3).name, "m");
}

// One material in a solid and a sheet is calibrated for each.
TEST(SheetScenes, AMaterialMayBeInSheetsAndSolids) {
  const Scene scene =
      parsed(scene_with("", "young = 1e5\npoisson = 0.3", a_sheet) + "[[body]]\nmaterial = \"m\"\n" +
             "shape = { box = [1, 1, 1], at = [0, 0, 2] }\n");
  const Model model = assemble(scene);
  const LawConstants solid = law_constants(Law::corotated, 1e5, 0.3, 0.5),
                     flat = law_constants(Law::corotated, 1e5, 0.3, 0.5, Neighbourhood::plane_stress);
  for (std::uint32_t i = 0; i < model.count(); ++i)
    EXPECT_EQ(model.constants[model.material[i]].modulus, model.body[i] == 0 ? flat.modulus : solid.modulus);
}

TEST(SheetScenes, Refused) {
  EXPECT_THAT(complaint(scene_with("", "", "shape = { sheet = [1, 0.5] }")),
              AllOf(StartsWith("s.toml:8:9:"), HasSubstr("lacks \"thickness\"")));
  EXPECT_THAT(complaint(scene_with("", "", a_box + "\nthickness = 0.01")),
              AllOf(StartsWith("s.toml:9:1:"), HasSubstr("applies to a sheet or a mesh")));
  EXPECT_THAT(complaint(scene_with("", "", a_sheet + "\n[[body.fixed]]\nregion = { sheet = [1, 1] }")),
              HasSubstr("a sheet encloses nothing"));
  EXPECT_THAT(complaint(scene_with("", "", a_box) + "[[boundary]]\nshape = { sheet = [1, 1] }\n"),
              HasSubstr("a sheet keeps nothing out"));
  EXPECT_THAT(complaint(scene_with("", "", "shape = { sheet = [1, -1] }\nthickness = 0.01")),
              HasSubstr("above 0"));
  EXPECT_THAT(complaint(scene_with("", "", "shape = { sheet = [1, 1] }\nthickness = 0")),
              HasSubstr("above 0"));
}

TEST(SheetScenes, RatiosByUse) {
  EXPECT_EQ(complaint(scene_with("", "poisson = 0.95", a_sheet)), "");
  EXPECT_THAT(complaint(scene_with("", "poisson = 0.96", a_sheet)), HasSubstr("0 to 0.95"));
  EXPECT_THAT(complaint(scene_with("", "poisson = 0.6", a_box)),
              AllOf(StartsWith("s.toml:5:11:"), HasSubstr("must be 0 to 0.499")));
  EXPECT_THAT(complaint(scene_with("dimension = 2", "poisson = 0.6", a_box)),
              HasSubstr("must be 0 to 0.499"));
  EXPECT_EQ(complaint(scene_with("dimension = 2\nplane = \"stress\"", "poisson = 0.6", a_box)), "");
  const Scene third = parsed(scene_with("", "law = \"projective\"", a_sheet));
  EXPECT_NEAR(third.materials[0].poisson, 1. / 3, 1e-15);
  EXPECT_EQ(complaint(scene_with("", "law = \"projective\"\npoisson = \"1/3\"", a_sheet)), "");
  EXPECT_THAT(complaint(scene_with("", "law = \"projective\"\npoisson = 0.25", a_sheet)),
              HasSubstr("1/3 in sheets"));
  EXPECT_THAT(complaint(scene_with("", "law = \"projective\"", a_sheet) + "[[body]]\nmaterial = \"m\"\n" +
                        a_box + "\n"),
              HasSubstr("give each its own"));
}

TEST(SheetScenes, HorizonsBetweenShells) {
  for (const char* good : {"1.8", "1.74", "2.1", "2.45", "2.6", "3.1"})
    EXPECT_EQ(complaint(scene_with(std::string("horizon = ") + good, "", a_sheet)), "") << good;
  EXPECT_THAT(complaint(scene_with("horizon = 2.0", "", a_sheet)), HasSubstr("the square lattice (sqrt(4)"));
  EXPECT_THAT(complaint(scene_with("horizon = 1.74", "", a_box)), HasSubstr("the cubic lattice (sqrt(3)"));
  EXPECT_THAT(
      complaint(scene_with("horizon = 1.74", "", a_sheet) + "[[body]]\nmaterial = \"m\"\n" + a_box + "\n"),
      HasSubstr("the cubic lattice"));
  EXPECT_THAT(complaint(scene_with("", "", a_sheet + "\nhorizon = 2.24")),
              AllOf(StartsWith("s.toml:10:11:"), HasSubstr("body.0.horizon = 2.24 lies within 1 %")));
  EXPECT_THAT(complaint(scene_with("influence = \"constant\"\nweight_exponent = 1", "", a_sheet)),
              HasSubstr("applies where influence = \"power\""));
}

TEST(PlaneScenes, RefuseWhatWouldLeaveThePlane) {
  const auto refused = [](const std::string& simulation, const std::string& body,
                          const std::string& more = "") {
    return complaint(scene_with("dimension = 2\n" + simulation, "", body) + more);
  };
  EXPECT_EQ(refused("", a_box + "\nspin = [0, 0, 3]"), "");
  EXPECT_THAT(refused("gravity = [0, 0, -9.81]", a_box),
              AllOf(StartsWith("s.toml:4:11"), HasSubstr("z is -9.81")));
  EXPECT_THAT(refused("", a_box + "\nvelocity = [0, 0, 1]"), HasSubstr("body.0.velocity"));
  EXPECT_THAT(refused("", a_box + "\nspin = [1, 0, 0]"), HasSubstr("[0, 0, 1] or its opposite"));
  EXPECT_THAT(refused("", "shape = { box = [1, 1, 1], at = [0, 0, 1] }"), HasSubstr("body.0.shape.at"));
  EXPECT_THAT(refused("", "shape = { box = [1, 1, 1], rotate = { axis = [1, 0, 0], degrees = 3 } }"),
              HasSubstr("rotate.axis"));
  EXPECT_THAT(refused("", "shape = { torus = { ring = 1, tube = 0.2 } }"), HasSubstr("of which the section"));
  EXPECT_THAT(refused("", a_box + "\ndeform = [[1, 0, 0], [0, 1, 0], [0, 0, 2]]"),
              HasSubstr("third row and column"));
  EXPECT_THAT(refused("", a_box + "\n[[body.loaded]]\nregion = { box = [2, 2, 2] }\nforce = [0, 0, 1]"),
              HasSubstr("body.0.loaded.0.force"));
  EXPECT_THAT(refused("", a_box + "\n[[body.moved]]\nregion = { box = [2, 2, 2] }\nvelocity = [0, 0, 1]"),
              HasSubstr("body.0.moved.0.velocity"));
  EXPECT_THAT(refused("", a_box, "[[boundary]]\nshape = { plane = [0, 0, 1] }\n"),
              HasSubstr("boundary.0.shape.plane"));
  EXPECT_THAT(complaint(scene_with("plane = \"stress\"", "", a_box)),
              HasSubstr("applies where dimension = 2"));
}

TEST(PlaneScenes, SectionsHaveTheirAreas) {
  const auto volume = [](const std::string& shape, const std::string& more = "") {
    const Model model =
        assemble(parsed(scene_with("dimension = 2", "", "shape = { " + shape + " }\n" + more)));
    double sum = 0;
    for (std::uint32_t i = 0; i < model.count(); ++i) {
      sum += model.volume[i];
      EXPECT_EQ(model.position[i].z(), 0);
    }
    return sum;
  };
  EXPECT_NEAR(volume("box = [1, 0.8, 0.3]"), 0.8, 1e-12);
  EXPECT_NEAR(volume("sphere = 0.5"), 3.14159265358979 / 4, 1e-9);
  EXPECT_NEAR(volume("cylinder = { radius = 0.4, height = 1 }"), 0.8, 1e-12);
  EXPECT_NEAR(volume("sheet = [1, 0.8]", "thickness = 0.5"), 0.4, 1e-12);
}

class MeshSheets : public testing::Test {
protected:
  MeshSheets() { std::filesystem::create_directories(folder_); }
  ~MeshSheets() override { std::filesystem::remove_all(folder_); }
  Scene scene(const Mesh& mesh, const std::string& body = "thickness = 0.01") const {
    write_mesh(mesh, folder_ / "cloth.obj");
    return parse_scene(scene_with("", "", "shape = { mesh = \"cloth.obj\" }\n" + body), folder_ / "s.toml");
  }
  static double distance(const Model& model, std::uint32_t i) {
    double least = 1e300;
    for (std::uint32_t b = model.bonds.begin[i]; b < model.bonds.begin[i + 1]; ++b)
      least = std::min(least, (model.reference[model.bonds.neighbour[b]] - model.reference[i]).norm());
    return least;
  }
  std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) / ("pliant-sheets-" + std::to_string(::getpid()));
};

/// Part of a cylinder of radius 1 and height 2 about y.
Mesh half_pipe() {
  Mesh mesh;
  for (int j = 0; j <= 10; ++j)
    for (int i = 0; i <= 24; ++i) {
      const double angle = 3.14159265358979 * i / 24;
      mesh.vertices.emplace_back(std::cos(angle), 0.2 * j, std::sin(angle));
    }
  for (std::uint32_t j = 0; j < 10; ++j)
    for (std::uint32_t i = 0; i < 24; ++i) {
      const std::uint32_t a = 25 * j + i;
      mesh.triangles.push_back({a, a + 1, a + 26});
      mesh.triangles.push_back({a, a + 26, a + 25});
    }
  return mesh;
}

TEST_F(MeshSheets, FlatOnesGetALattice) {
  Mesh mesh; // an L in the plane y = 3, off the lattice's directions
  mesh.vertices = {{0, 3, 0}, {1, 3, 0}, {1, 3, 0.5}, {0.5, 3, 0.5}, {0.5, 3, 1}, {0, 3, 1}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}};
  const Model model = assemble(scene(mesh));
  EXPECT_EQ(model.count(), 75u);
  double volume = 0;
  for (std::uint32_t i = 0; i < model.count(); ++i) {
    volume += model.volume[i];
    EXPECT_NEAR(model.position[i].y(), 3, 1e-12);
    EXPECT_NEAR(distance(model, i), 0.1, 1e-12);
  }
  EXPECT_NEAR(volume, 0.0075, 1e-12);
  EXPECT_TRUE(model.bodies[0].surface.has_value());
}

TEST_F(MeshSheets, CurvedOnesAreCoveredEvenly) {
  const Mesh mesh = half_pipe();
  const Model model = assemble(scene(mesh));
  const double area = examine(mesh).area;
  expect_below("particles a square of the spacing, less one",
               std::abs(static_cast<double>(model.count()) * 0.01 / area - 1), 0.05);
  double volume = 0, least = 1e300, most = 0, off = 0;
  for (std::uint32_t i = 0; i < model.count(); ++i) {
    volume += model.volume[i];
    least = std::min(least, distance(model, i));
    most = std::max(most, distance(model, i));
    off = std::max(off, std::abs(std::hypot(model.position[i].x(), model.position[i].z()) - 1));
  }
  EXPECT_NEAR(volume, 0.01 * area, 1e-12);
  expect_above("nearest neighbour, at least, spacings", least / 0.1, 0.7);
  expect_below("nearest neighbour, at most, spacings", most / 0.1, 1.25);
  expect_below("off the surface (its facets are 2e-3), m", off, 3e-3);
  expect_below("share whose second moments miss by 5 %", model.weight_report.share_over_5_percent, 0.02);
  const Model again = assemble(scene(mesh));
  EXPECT_EQ(model.reference, again.reference);
}

TEST_F(MeshSheets, OpenOnesNeedAThickness) {
  try {
    assemble(scene(half_pipe(), ""));
    FAIL() << "an open mesh was filled";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::usage);
    EXPECT_THAT(error.what(), AllOf(HasSubstr("is open"), HasSubstr("give the body a thickness")));
  }
}

// A closed mesh with a thickness is a closed shell.
TEST_F(MeshSheets, ClosedOnesBecomeShells) {
  Mesh mesh;
  for (int corner = 0; corner < 8; ++corner)
    mesh.vertices.emplace_back(corner & 1, corner >> 1 & 1, corner >> 2);
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  const Model model = assemble(scene(mesh));
  double mass = 0;
  for (std::uint32_t i = 0; i < model.count(); ++i) {
    mass += model.volume[i];
    EXPECT_NEAR((model.position[i] - Vector3(0.5, 0.5, 0.5)).cwiseAbs().maxCoeff(), 0.5, 1e-3) << i;
  }
  EXPECT_NEAR(mass, 0.06, 1e-12);
}

// What a scene of solids has is what it had: no component of sheets, the variants with zero options.
TEST(SheetPlan, SolidsHaveNothingOfSheets) {
  const auto plan_of = [](const std::string& text, const std::string& method) {
    const Scene scene =
        parsed(text + "[solver]\nmethod = \"" + method + "\"\npreconditioner = \"diagonal\"\n");
    const Model model = assemble(scene);
    return make_plan(scene, model, slice_bonds(model), {});
  };
  const auto has = [](const std::vector<std::string>& names, const char* name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  const auto option = [](const Plan& plan, const std::string& kernel) {
    for (const KernelSpec& spec : plan.kernels)
      if (spec.info->name == kernel) return spec.options.at(0);
    return 99u;
  };
  const std::string solid = scene_with("", "", a_box), sheet = scene_with("", "", a_sheet),
                    plane = scene_with("dimension = 2", "", a_box);
  const Plan plain = plan_of(solid, "newton"), flat = plan_of(sheet, "newton"),
             planar = plan_of(plane, "newton");
  EXPECT_TRUE(has(plain.left_out, "sheets") && has(plain.left_out, "plane"));
  EXPECT_TRUE(has(flat.used, "sheets") && has(flat.left_out, "plane"));
  EXPECT_TRUE(has(planar.used, "plane") && has(planar.left_out, "sheets"));
  EXPECT_EQ(option(plain, "corotated_state"), 0u);
  EXPECT_EQ(option(plain, "corotated_tangent"), 0u);
  EXPECT_EQ(option(flat, "corotated_state"), 0u);
  EXPECT_EQ(option(flat, "corotated_tangent"), 1u);
  EXPECT_EQ(option(planar, "corotated_state"), 1u);
  EXPECT_EQ(option(planar, "corotated_tangent"), 1u);
  // Flatness needs no buffer.
  for (const BufferSpec& buffer : flat.buffers) EXPECT_NE(plain.find(buffer.name), nullptr) << buffer.name;
  EXPECT_EQ(flat.buffers.size(), plain.buffers.size());
}

TEST(SheetPlan, AutoTakesTheFactorOfSheetsThatTouchNothing) {
  const std::string cloth = "young = 1e6";
  const Scene alone = parsed(scene_with("", cloth, a_sheet));
  const Method method = choose_method(alone, assemble(alone));
  EXPECT_GT(method.stiffness_number, 50);
  EXPECT_LT(method.stiffness_number, 1e5);
  EXPECT_EQ(method.name, "lbfgs");
  EXPECT_EQ(method.preconditioner, "direct");
  const Scene touching = parsed(scene_with("", cloth, a_sheet) + "[contact]\nself = true\n");
  EXPECT_NE(choose_method(touching, assemble(touching)).preconditioner, "direct");
  const Scene tearing = parsed(scene_with("", cloth + "\nfracture_energy = 10", a_sheet));
  EXPECT_NE(choose_method(tearing, assemble(tearing)).preconditioner, "direct");
}

TEST(SheetPlan, AutoLeavesTheMultilevelPreconditionerOut) {
  const Scene scene = parsed(scene_with("", "young = 1e9", a_sheet));
  const Method method = choose_method(scene, assemble(scene));
  EXPECT_EQ(method.name, "newton");
  EXPECT_EQ(method.preconditioner, "diagonal");
  EXPECT_THAT(method.reason, HasSubstr("do not bend as sheets do"));
  const Scene plane = parsed(scene_with("dimension = 2", "young = 1e9", a_box) +
                             "[solver]\nmethod = \"newton\"\npreconditioner = \"multilevel\"\n");
  EXPECT_THROW(choose_method(plane, assemble(plane)), Error);
}

} // namespace
} // namespace pliant::test
