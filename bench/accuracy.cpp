// How accurate the elastic laws are: Young's modulus that a tension test returns against the one that was
// typed, by thickness of the bar, for moment-matched and for plain normalised weights. Writes accuracy.csv
// and accuracy.png.
//
//   build/bench/accuracy [FOLDER]
#include "engine/core/error.h"
#include "engine/render/plot.h"
#include "engine/solver/simulation.h"

#include <cstdio>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>

using namespace pliant;

namespace {

constexpr double spacing = 0.01, strain = 1e-4;
constexpr int length = 30;

using Field = std::vector<Vector3>;

double inner(const Field& a, const Field& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i].dot(b[i]);
  return sum;
}

/// Young's modulus of a bar of n x n layers whose ends are drawn apart, by conjugate gradients on the exact
/// forces.
double measured_modulus(const std::string& law, const std::string& weights, int n, double poisson) {
  Material material;
  material.name = "bar";
  material.law = law;
  material.young = 1;
  material.poisson = poisson;
  Field points;
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < length; ++x) points.push_back(Vector3(x, y, z) * spacing);
  Scene scene;
  scene.simulation.spacing = spacing;
  scene.materials = {material};
  const Model model = assemble_points(points, spacing, 1.87, material, spacing * spacing * spacing, weights);
  const auto device = open_device({"openmp", Precision::double_precision, 0, false});
  Simulation simulation(*device, scene, model);
  const Field rest = model.position;
  const std::size_t count = rest.size();
  const auto at_end = [&](std::size_t i) {
    return rest[i].x() < 0.5 * spacing || rest[i].x() > (length - 1.5) * spacing;
  };
  const auto free = [&](Field f) {
    for (std::size_t i = 0; i < count; ++i)
      if (at_end(i)) f[i].x() = 0;
    return f;
  };
  // Stiffness times a small displacement, by a central difference.
  const auto stiffness = [&](const Field& u) {
    double size = 0;
    for (const Vector3& v : u) size = std::max(size, v.cwiseAbs().maxCoeff());
    if (size == 0) return Field(count, Vector3::Zero());
    const double step = 1e-5 * spacing / size;
    Field plus = rest, minus = rest;
    for (std::size_t i = 0; i < count; ++i) plus[i] += step * u[i], minus[i] -= step * u[i];
    Field a = simulation.elastic_forces(plus);
    const Field b = simulation.elastic_forces(minus);
    for (std::size_t i = 0; i < count; ++i) a[i] = (b[i] - a[i]) / (2 * step);
    return a;
  };
  Field u(count, Vector3::Zero());
  for (std::size_t i = 0; i < count; ++i) u[i].x() = strain * (rest[i].x() - (length - 1) * spacing / 2);
  Field r = free(stiffness(u));
  for (Vector3& v : r) v = -v;
  Field p = r;
  double rr = inner(r, r);
  const double target = 1e-14 * inner(stiffness(u), stiffness(u));
  for (int k = 0; k < 2000 && rr > target; ++k) {
    const Field kp = free(stiffness(p));
    const double alpha = rr / inner(p, kp);
    for (std::size_t i = 0; i < count; ++i) u[i] += alpha * p[i], r[i] -= alpha * kp[i];
    const double next = inner(r, r);
    for (std::size_t i = 0; i < count; ++i) p[i] = r[i] + next / rr * p[i];
    rr = next;
  }
  const Field force = stiffness(u);
  double pull = 0, left = 0, right = 0;
  const int a = length / 2 - 5, b = length / 2 + 5;
  for (std::size_t i = 0; i < count; ++i) {
    if (rest[i].x() > (length - 1.5) * spacing) pull += force[i].x();
    if (std::abs(rest[i].x() - a * spacing) < 0.1 * spacing) left += u[i].x() / (n * n);
    if (std::abs(rest[i].x() - b * spacing) < 0.1 * spacing) right += u[i].x() / (n * n);
  }
  const double area = n * n * spacing * spacing;
  return pull / area / ((right - left) / ((b - a) * spacing));
}

} // namespace

int main(int argc, char** argv) try {
  const std::filesystem::path folder = argc > 1 ? argv[1] : ".";
  std::filesystem::create_directories(folder);
  std::ofstream csv(folder / "accuracy.csv");
  csv << "law,weights,layers,poisson,modulus_over_typed\n";
  Plot plot;
  plot.title = "What a tension test returns of the modulus typed (Poisson's ratio 0.25)";
  plot.x_label = "layers across the bar";
  plot.y_label = "measured E / typed E";
  for (const auto& [law, weights] : {std::pair{"corotated", "matched"},
                                     {"ordinary", "matched"},
                                     {"projective", "matched"},
                                     {"corotated", "normalised"},
                                     {"ordinary", "normalised"}}) {
    Series series;
    series.label = fmt::format("{}, {} weights", law, weights);
    for (int layers = 2; layers <= 7; ++layers) {
      const double ratio = measured_modulus(law, weights, layers, 0.25);
      series.x.push_back(layers);
      series.y.push_back(ratio);
      csv << fmt::format("{},{},{},0.25,{:.6f}\n", law, weights, layers, ratio);
      fmt::print("{:<10} {:<10} {} layers  E/E0 {:.5f}\n", law, weights, layers, ratio);
    }
    plot.series.push_back(series);
  }
  write_png(plot, folder / "accuracy.png");
  fmt::print("{}\n", (folder / "accuracy.png").string());
  return 0;
} catch (const Error& error) {
  fmt::print(stderr, "accuracy: {}\n", error.what());
  return static_cast<int>(error.code());
}
