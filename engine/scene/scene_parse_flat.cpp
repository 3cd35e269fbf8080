// The rules of a scene file about what is flat: sheets, plane scenes, the horizons and Poisson's ratios that
// they may have.
#include "engine/model/stretch_energy.h"
#include "engine/scene/scene_parse_findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace pliant {
namespace {

using Kind = TomlValue::Kind;

/// A cubic lattice has neighbours at sqrt(a2 + b2 + c2), a square one at sqrt(a2 + b2); between two of these
/// a horizon is safe.
constexpr std::array<double, 7> good_horizons = {1.87, 2.1, 2.35, 2.6, 3.1, 3.67, 4.06};
constexpr std::array<double, 6> good_flat_horizons = {1.8, 2.1, 2.6, 3.1, 3.8, 4.06};
constexpr double shell_margin = 0.01 + 1e-9; // so that 1.98 and 2.02 themselves are refused

bool sum_of_three_squares(int n) {
  while (n % 4 == 0) n /= 4; // Legendre: all but 4^a (8 b + 7)
  return n % 8 != 7;
}
bool sum_of_two_squares(int n) {
  for (int a = 0; a * a <= n; ++a) {
    const int b = static_cast<int>(std::lround(std::sqrt(n - a * a)));
    if (a * a + b * b == n) return true;
  }
  return false;
}

bool is_sheet(const Scene& scene, const Body& body) {
  return scene.simulation.dimension == 3 && (body.thickness || body.shape.kind == Shape::Kind::sheet);
}

/// An entry of a table of the document, or null.
const TomlValue* typed(const TomlValue* table, const char* key) {
  return table && table->kind == Kind::table ? table->find(key) : nullptr;
}
/// Element `i` of the list `name` of the document, or null.
const TomlValue* element(const TomlValue& table, const char* name, std::size_t i) {
  const TomlValue* list = table.find(name);
  return list && list->kind == Kind::array && i < list->items.size() ? &list->items[i] : nullptr;
}

void check_horizon(const TomlValue* value, const std::string& path, double horizon, bool flat,
                   Findings& findings) {
  for (int n = 1; value && n <= 18; ++n) {
    const double shell = std::sqrt(n);
    if (!(flat ? sum_of_two_squares(n) : sum_of_three_squares(n)) ||
        std::abs(horizon / shell - 1) > shell_margin)
      continue;
    const std::span<const double> all =
        flat ? std::span<const double>(good_flat_horizons) : std::span<const double>(good_horizons);
    const double good = *std::min_element(all.begin(), all.end(), [&](double a, double b) {
      return std::abs(a - horizon) < std::abs(b - horizon);
    });
    findings.add(
        value->where,
        fmt::format(
            "{}.horizon = {} lies within 1 % of a shell of the {} lattice (sqrt({}) = {:.4g} "
            "spacings), where rounding decides which particles are neighbours; the nearest good one is {}",
            path, horizon, flat ? "square" : "cubic", n, shell, good));
    return;
  }
}

void check_horizons(const TomlValue& document, const Scene& scene, Findings& findings) {
  bool all_flat = !scene.bodies.empty();
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const Body& body = scene.bodies[b];
    const bool flat = scene.simulation.dimension == 2 || is_sheet(scene, body);
    if (body.horizon)
      check_horizon(typed(element(document, "body", b), "horizon"), fmt::format("body.{}", b), *body.horizon,
                    flat, findings);
    else
      all_flat = all_flat && flat;
  }
  check_horizon(typed(document.find("simulation"), "horizon"), "simulation", scene.simulation.horizon,
                all_flat, findings);
}

/// Which bodies a material is in.
struct Uses {
  bool solids = false, sheets = false;
};
Uses uses_of(const Scene& scene, const Material& material) {
  Uses uses;
  for (const Body& body : scene.bodies) {
    const auto its = [&](const std::string& name) { return name == material.name; };
    if (its(body.material) || std::any_of(body.regions.begin(), body.regions.end(),
                                          [&](const auto& region) { return its(region.material); }))
      (is_sheet(scene, body) || (scene.simulation.dimension == 2 && scene.simulation.plane == "stress")
           ? uses.sheets
           : uses.solids) = true;
  }
  return uses;
}

/// Solids and plane strain: at most 0.499. The projective law: 1/4, in sheets and plane stress 1/3.
void check_ratio(const TomlValue& table, Material& material, const Uses& uses, Findings& findings) {
  const TomlValue* value = typed(&table, "poisson");
  if (value && value->kind != Kind::text && !value->is_number()) return;
  const std::string path = "materials." + material.name;
  if (material.law != "projective") {
    if (value && material.poisson > 0.499 && (uses.solids || !uses.sheets))
      findings.add(value->where,
                   fmt::format("{}.poisson = {} is out of range: it must be 0 to 0.499, because at 0.5 "
                               "the bulk modulus is infinite (sheets and plane stress allow 0.95)",
                               path, material.poisson));
    return;
  }
  if (uses.sheets && uses.solids) {
    findings.add(table.key_where,
                 fmt::format("{}: law = \"projective\" has ratio 1/3 in sheets and 1/4 in solids, and "
                             "this material is used in both; give each its own",
                             path));
    return;
  }
  const double ratio = uses.sheets ? 1. / 3 : 0.25;
  if (value && std::abs(material.poisson - ratio) > (uses.sheets ? 5e-4 : 0))
    findings.add(
        value->where,
        fmt::format("{}.poisson = {} cannot be had with law = \"projective\": that law always has ratio {}, "
                    "whatever is typed; for another ratio choose law = \"corotated\"",
                    path, material.poisson, uses.sheets ? "1/3 in sheets" : "1/4"));
  material.poisson = ratio;
}

/// Of every material for what it fills; after all else, because faults of its keys would be found twice.
void check_energies(const TomlValue& document, const Scene& scene, Findings& findings) {
  const TomlValue* tables = document.find("materials");
  if (findings.count() > 0 || !tables || tables->kind != Kind::table) return;
  for (std::size_t m = 0; m < tables->items.size() && m < scene.materials.size(); ++m) {
    const Material& material = scene.materials[m];
    const Uses uses = uses_of(scene, material);
    const auto check = [&](Neighbourhood neighbourhood) {
      check_energy(tables->items[m], material, neighbourhood, "materials." + material.name, findings);
    };
    if (uses.sheets) check(Neighbourhood::plane_stress);
    if (uses.solids || !uses.sheets)
      check(scene.simulation.dimension == 2 ? Neighbourhood::plane_strain : Neighbourhood::solid);
  }
}

void check_thickness(const TomlValue& document, const Scene& scene, Findings& findings) {
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const TomlValue* table = element(document, "body", b);
    const TomlValue* shape = typed(table, "shape");
    if (!shape) continue;
    const Body& body = scene.bodies[b];
    const Shape::Kind kind = body.shape.kind;
    const TomlValue* thickness = typed(table, "thickness");
    if (scene.simulation.dimension == 3 && kind == Shape::Kind::sheet && !thickness)
      findings.add(shape->where,
                   fmt::format("body.{} is a sheet and lacks \"thickness\", such as thickness = 0.001 (m): "
                               "a particle stands for the square of the spacing times it",
                               b));
    if (scene.simulation.dimension == 3 && thickness && kind != Shape::Kind::sheet &&
        kind != Shape::Kind::mesh)
      findings.add(thickness->key_where,
                   fmt::format("body.{}.thickness applies to a sheet or a mesh: other shapes are filled", b));
    for (const char* list : {"region", "fixed", "moved", "loaded", "deformed"})
      for (std::size_t i = 0; const TomlValue* part = element(*table, list, i); ++i)
        if (const TomlValue* region = typed(part, "region"); typed(region, "sheet"))
          findings.add(
              region->where,
              fmt::format("body.{}.{}.{}.region: a sheet encloses nothing; use a thin box", b, list, i));
  }
  for (std::size_t b = 0; b < scene.boundaries.size(); ++b)
    if (scene.boundaries[b].shape.kind == Shape::Kind::sheet)
      if (const TomlValue* shape = typed(element(document, "boundary", b), "shape"))
        findings.add(shape->where,
                     fmt::format("boundary.{}.shape: a sheet keeps nothing out; use a thin box", b));
}

/// Nothing may leave the plane z = 0 of a scene of dimension 2.
class PlaneRules {
public:
  PlaneRules(const TomlValue& document, Scene& scene, Findings& findings)
      : document_(document), scene_(scene), findings_(findings) {}

  void check() {
    const TomlValue* simulation = document_.find("simulation");
    along("simulation.gravity", typed(simulation, "gravity"), scene_.simulation.gravity);
    for (std::size_t b = 0; b < scene_.bodies.size(); ++b)
      if (const TomlValue* table = element(document_, "body", b)) body(*table, scene_.bodies[b], b);
    for (std::size_t b = 0; b < scene_.boundaries.size(); ++b)
      if (const TomlValue* table = element(document_, "boundary", b)) {
        Boundary& boundary = scene_.boundaries[b];
        const std::string path = fmt::format("boundary.{}", b);
        shape(typed(table, "shape"), boundary.shape, path + ".shape");
        motion(*table, boundary.motion, path);
        // A box reaches as far across the plane as anything could look: its sides there never are the nearest
        // ones.
        if (boundary.shape.kind == Shape::Kind::box)
          boundary.shape.size.z() = 4 * std::max(boundary.shape.size.x(), boundary.shape.size.y());
      }
  }

private:
  static constexpr const char* why = "with dimension = 2 everything stays in the plane z = 0";

  void along(const std::string& path, const TomlValue* value, const Vector3& v) {
    if (value && v.z() != 0)
      findings_.add(value->where, fmt::format("{}: its z is {} and must be 0: {}", path, v.z(), why));
  }
  void axis(const std::string& path, const TomlValue* value, const Vector3& v) {
    if (value && (v.x() != 0 || v.y() != 0))
      findings_.add(value->where, fmt::format("{} must be [0, 0, 1] or its opposite: {}", path, why));
  }
  void shape(const TomlValue* value, const Shape& shape, const std::string& path) {
    if (!value) return;
    if (shape.kind == Shape::Kind::mesh || shape.kind == Shape::Kind::torus)
      findings_.add(value->where,
                    fmt::format("{}: with dimension = 2 a shape is a box, sphere, cylinder, sheet or "
                                "plane, of which the section with z = 0 counts",
                                path));
    along(path + ".at", typed(value, "at"), shape.at);
    along(path + ".plane", typed(value, "plane"), shape.normal);
    axis(path + ".rotate.axis", typed(typed(value, "rotate"), "axis"), shape.rotate_axis);
  }
  void motion(const TomlValue& table, const Motion& motion, const std::string& path) {
    along(path + ".velocity", typed(&table, "velocity"), motion.velocity);
    axis(path + ".rotation.axis", typed(typed(&table, "rotation"), "axis"), motion.axis);
  }
  void deform(const TomlValue* value, const Matrix3& m, const std::string& path) {
    if (value && (m(0, 2) != 0 || m(1, 2) != 0 || m(2, 0) != 0 || m(2, 1) != 0 || m(2, 2) != 1))
      findings_.add(value->where, fmt::format("{}: its third row and column must be 0, 0, 1: {}", path, why));
  }
  void body(const TomlValue& table, Body& body, std::size_t b) {
    const std::string path = fmt::format("body.{}", b);
    shape(typed(&table, "shape"), body.shape, path + ".shape");
    along(path + ".velocity", typed(&table, "velocity"), body.velocity);
    axis(path + ".spin", typed(&table, "spin"), body.spin);
    deform(typed(&table, "deform"), body.deform, path + ".deform");
    for (std::size_t i = 0; i < body.deformed.size(); ++i)
      deform(typed(element(table, "deformed", i), "deform"), body.deformed[i].deform,
             fmt::format("{}.deformed.{}.deform", path, i));
    std::size_t moved = 0, loaded = 0;
    for (const Condition& condition : body.conditions) {
      if (condition.kind == Condition::Kind::moved) {
        if (const TomlValue* entry = element(table, "moved", moved))
          motion(*entry, condition.motion, fmt::format("{}.moved.{}", path, moved));
        ++moved;
      } else if (condition.kind == Condition::Kind::loaded) {
        along(fmt::format("{}.loaded.{}.force", path, loaded),
              typed(element(table, "loaded", loaded), "force"), condition.force);
        ++loaded;
      }
    }
  }

  const TomlValue& document_;
  Scene& scene_;
  Findings& findings_;
};

} // namespace

void check_flat(const TomlValue& document, Scene& scene, Findings& findings) {
  check_horizons(document, scene, findings);
  if (const TomlValue* tables = document.find("materials"); tables && tables->kind == Kind::table)
    for (std::size_t m = 0; m < tables->items.size() && m < scene.materials.size(); ++m)
      check_ratio(tables->items[m], scene.materials[m], uses_of(scene, scene.materials[m]), findings);
  check_energies(document, scene, findings);
  const TomlValue* simulation = document.find("simulation");
  if (scene.simulation.influence != "power")
    if (const TomlValue* exponent = typed(simulation, "weight_exponent"))
      findings.add(exponent->key_where,
                   fmt::format("simulation.weight_exponent applies where influence = \"power\"; it is \"{}\"",
                               scene.simulation.influence));
  if (scene.simulation.dimension == 3)
    if (const TomlValue* plane = typed(simulation, "plane"))
      findings.add(plane->key_where, "simulation.plane applies where dimension = 2; it is 3");
  check_thickness(document, scene, findings);
  if (scene.simulation.dimension == 2) PlaneRules(document, scene, findings).check();
}

} // namespace pliant
