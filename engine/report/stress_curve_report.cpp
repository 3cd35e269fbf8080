// Stress against stretch for people, for programs and as pictures.
#include "engine/io/folder.h"
#include "engine/render/plot.h"
#include "engine/report/stress_curve.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cctype>
#include <cmath>

namespace pliant {

namespace {

/// Of the wanted value; nothing at rest, where both are zero.
double deviation(const StressPoint& point, const StressPoint& wanted, double young) {
  if (std::abs(wanted.stress) < 1e-9 * young) return std::nan("");
  return (point.stress - wanted.stress) / std::abs(wanted.stress);
}

std::string percent(double share) {
  return std::isfinite(share) ? fmt::format("{:+.2f} %", 100 * share) : "-";
}

std::string value(double number, double scale = 1) {
  if (!std::isfinite(number)) return "none";
  const double shown = number / scale;
  return fmt::format("{:.4f}", std::abs(shown) < 5e-5 ? 0.0 : shown);
}

/// Largest size of the deviations, where there is one.
double worst(const std::vector<StressPoint>& points, const std::vector<StressPoint>& wanted, double young) {
  double size = 0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double one = std::abs(deviation(points[k], wanted[k], young));
    if (std::isfinite(one)) size = std::max(size, one);
  }
  return size;
}

nlohmann::json numbers(const std::vector<StressPoint>& points, double StressPoint::*member) {
  nlohmann::json list = nlohmann::json::array();
  for (const StressPoint& point : points)
    list.push_back(std::isfinite(point.*member) ? nlohmann::json(point.*member) : nlohmann::json(nullptr));
  return list;
}

std::string file_name(const std::string& material) {
  std::string name = material;
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '-' && c != '_') c = '_';
  return name;
}

std::string csv_number(double number) {
  return std::isfinite(number) ? fmt::format("{:.10g}", number) : "";
}

std::string csv(const StressCurveReport& report) {
  std::string text = "material,test,stretch,lattice_stress_Pa,lattice_lateral,continuum_stress_Pa,"
                     "continuum_lateral,closed_stress_Pa,closed_lateral\n";
  for (const MaterialCurves& material : report.materials)
    for (const StressCurve& curve : material.curves)
      for (std::size_t k = 0; k < report.stretches.size(); ++k) {
        text += fmt::format("{},{},{:.10g}", file_name(material.material), stress_test_name(curve.test),
                            report.stretches[k]);
        for (const auto* points : {&curve.lattice, &curve.continuum, &curve.closed}) {
          const bool there = !points->empty();
          text += "," + (there ? csv_number((*points)[k].stress) : "") + "," +
                  (there ? csv_number((*points)[k].lateral) : "");
        }
        text += "\n";
      }
  return text;
}

// A colour a test; points the lattice, a line the continuum, dashes the closed formula.
Plot plot_of(const StressCurveReport& report, const MaterialCurves& material) {
  constexpr Colour colours[] = {{0, 114, 178}, {213, 94, 0}, {0, 158, 115}};
  Plot plot;
  plot.title =
      material.material == material.law
          ? fmt::format("{} (Poisson's ratio {:g})", material.law, material.poisson)
          : fmt::format("{} ({}, Poisson's ratio {:g})", material.material, material.law, material.poisson);
  plot.x_label = "stretch s";
  plot.y_label = "stress / Young's modulus";
  double low = 0, high = 0;
  const auto add = [&](const std::string& label, const std::vector<StressPoint>& points, SeriesStyle style,
                       bool counts) {
    Series series{label, report.stretches, {}, style};
    for (const StressPoint& point : points) {
      series.y.push_back(point.stress / material.young);
      if (counts && std::isfinite(point.stress)) {
        low = std::min(low, series.y.back());
        high = std::max(high, series.y.back());
      }
    }
    plot.series.push_back(std::move(series));
  };
  for (std::size_t c = 0; c < material.curves.size(); ++c) {
    const StressCurve& curve = material.curves[c];
    const std::string name = stress_test_name(curve.test);
    SeriesStyle points, line, dashes;
    points.colour = line.colour = dashes.colour = colours[c % std::size(colours)];
    points.shape = static_cast<unsigned>(c);
    points.line = line.markers = dashes.markers = false;
    dashes.dashed = 1;
    add(name + ", lattice", curve.lattice, points, true);
    add(name + ", continuum", curve.continuum, line, true);
    if (!curve.closed.empty()) add(name + ", " + material.closed_name, curve.closed, dashes, false);
  }
  // A closed formula that runs away would leave nothing to see of the rest.
  plot.y_range = {low - 0.3 * (high - low), high + 0.3 * (high - low)};
  return plot;
}

} // namespace

std::string stress_curve_text(const StressCurveReport& report) {
  std::string text;
  const std::size_t every = std::max<std::size_t>(1, (report.stretches.size() - 1) / 15);
  for (const MaterialCurves& material : report.materials) {
    const bool closed = !material.closed_name.empty();
    text += fmt::format("{}{}: law {}, E = {:g} Pa, nu = {:g}; stress P over E, free side t\n",
                        text.empty() ? "" : "\n", material.material, material.law, material.young,
                        material.poisson);
    for (const StressCurve& curve : material.curves) {
      text += fmt::format("\n  {:<12}{:>10}{:>10}{:>11}{:>10}{:>12}", stress_test_name(curve.test), "lattice",
                          "t", "continuum", "t", "deviation");
      if (closed) text += fmt::format("{:>12}{:>10}{:>12}", "closed", "t", "deviation");
      text += "\n";
      for (std::size_t k = 0; k < report.stretches.size(); k += every) {
        const StressPoint &l = curve.lattice[k], &c = curve.continuum[k];
        text +=
            fmt::format("  s = {:<8.4g}{:>10}{:>10}{:>11}{:>10}{:>12}", report.stretches[k],
                        value(l.stress, material.young), value(l.lateral), value(c.stress, material.young),
                        value(c.lateral), percent(deviation(l, c, material.young)));
        if (closed) {
          const StressPoint& f = curve.closed[k];
          text += fmt::format("{:>12}{:>10}{:>12}", value(f.stress, material.young), value(f.lateral),
                              percent(deviation(l, f, material.young)));
        }
        text += "\n";
      }
      text += fmt::format("  largest deviation of the lattice from the continuum {:.2f} %",
                          100 * worst(curve.lattice, curve.continuum, material.young));
      if (closed)
        text += fmt::format(", from {} in closed form {:.1f} %", material.closed_name,
                            100 * worst(curve.lattice, curve.closed, material.young));
      text += "\n";
    }
  }
  return text;
}

nlohmann::json stress_curve_json(const StressCurveReport& report) {
  nlohmann::json result = {{"scene", report.scene}, {"stretch", report.stretches}};
  nlohmann::json& materials = result["materials"] = nlohmann::json::array();
  for (const MaterialCurves& material : report.materials) {
    nlohmann::json one = {{"material", material.material},
                          {"law", material.law},
                          {"young", material.young},
                          {"poisson", material.poisson},
                          {"closed_formula", material.closed_name.empty()
                                                 ? nlohmann::json(nullptr)
                                                 : nlohmann::json(material.closed_name)}};
    for (const StressCurve& curve : material.curves) {
      nlohmann::json test = {{"test", stress_test_name(curve.test)}};
      const auto add = [&](const char* name, const std::vector<StressPoint>& points) {
        test[name] = {{"stress", numbers(points, &StressPoint::stress)},
                      {"lateral", numbers(points, &StressPoint::lateral)}};
      };
      add("lattice", curve.lattice);
      add("continuum", curve.continuum);
      test["largest_deviation_from_continuum"] = worst(curve.lattice, curve.continuum, material.young);
      if (!curve.closed.empty()) {
        add("closed", curve.closed);
        test["largest_deviation_from_closed"] = worst(curve.lattice, curve.closed, material.young);
      }
      one["tests"].push_back(std::move(test));
    }
    materials.push_back(std::move(one));
  }
  return result;
}

std::vector<std::filesystem::path> write_stress_curves(const StressCurveReport& report,
                                                       const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> written = {folder / "curve.csv", folder / "curve.json"};
  write_text_file(written[0], csv(report));
  write_text_file(written[1], stress_curve_json(report).dump(2) + "\n");
  for (const MaterialCurves& material : report.materials) {
    const Plot plot = plot_of(report, material);
    const std::string name = file_name(material.material);
    written.push_back(folder / (name + ".svg"));
    write_svg(plot, written.back());
    written.push_back(folder / (name + ".png"));
    write_png(plot, written.back());
  }
  return written;
}

} // namespace pliant
