// pliant scenes: the examples that are at hand.
#include "engine/cli/commands.h"
#include "engine/scene/scene_parse.h"
#include "engine/scene/shape.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <set>

namespace pliant::cli {

namespace {

namespace fs = std::filesystem;

struct Listed {
  fs::path file;
  std::string name, description;
  double particles = 0; ///< about; 0: unknown
  std::string fault;    ///< first line, where the scene or its mesh will not do
};

std::string first_line(const std::string& text) {
  return text.substr(0, text.find('\n'));
}

/// The present folder, its examples/, and those of the program: beside the sources it was built from, or
/// installed.
std::vector<fs::path> scene_folders() {
  std::vector<fs::path> folders{".", PLIANT_SOURCE_EXAMPLES};
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (error) return folders;
  fs::path above = program.parent_path();
  for (int level = 0; level < 4 && above.has_relative_path(); ++level, above = above.parent_path()) {
    folders.push_back(above / "share" / "pliant" / "examples");
    folders.push_back(above / PLIANT_SOURCE_EXAMPLES);
  }
  return folders;
}

Listed look_at(const fs::path& file) {
  Listed listed{file, file.stem().string(), {}, 0, {}};
  try {
    const Scene scene = read_scene(file);
    listed.name = scene.name;
    listed.description = first_line(scene.description);
    double volume = 0;
    for (const Body& body : scene.bodies) volume += volume_of(place(body.shape, file.parent_path()));
    listed.particles = volume / std::pow(scene.simulation.spacing, 3);
  } catch (const Error& error) {
    listed.fault = first_line(error.what());
    if (const std::string in = " in any of"; listed.fault.ends_with(in)) // a list of folders follows
      listed.fault = listed.fault.substr(0, listed.fault.size() - in.size()) + ": see `pliant doctor`";
  }
  return listed;
}

bool is_scene(const fs::path& file) {
  if (file.extension() != ".toml") return false;
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored)) return false;
  // Other programs have TOML files too: ours say their format.
  std::FILE* stream = std::fopen(file.c_str(), "rb");
  if (!stream) return false;
  std::string text(1 << 16, '\0');
  text.resize(std::fread(text.data(), 1, text.size(), stream));
  std::fclose(stream);
  return text.rfind("format", 0) == 0 || text.find("\nformat") != std::string::npos;
}

std::vector<Listed> find_scenes() {
  std::vector<Listed> scenes;
  std::set<fs::path> seen;
  for (const fs::path& folder : scene_folders()) {
    std::vector<fs::path> files;
    std::error_code error;
    for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error))
      if (is_scene(at->path())) files.push_back(at->path().lexically_normal());
    std::sort(files.begin(), files.end());
    for (const fs::path& file : files)
      if (seen.insert(fs::weakly_canonical(file, error)).second) scenes.push_back(look_at(file));
  }
  return scenes;
}

/// Two digits are enough of an estimate: 28700 -> "29,000".
std::string about(double count) {
  if (!(count > 0)) return "";
  const double unit = std::pow(10, std::max(std::floor(std::log10(count)) - 1, 0.0));
  std::string digits = fmt::format("{:.0f}", std::round(count / unit) * unit);
  for (std::size_t at = digits.size(); at > 3; at -= 3) digits.insert(at - 3, ",");
  return digits;
}

ExitCode list(const JsonChoice& json) {
  const std::vector<Listed> scenes = find_scenes();
  if (json.wanted()) {
    nlohmann::json array = nlohmann::json::array();
    for (const Listed& scene : scenes)
      array.push_back(
          {{"file", scene.file.string()},
           {"name", scene.name},
           {"description", scene.description},
           {"particles", scene.particles > 0 ? nlohmann::json(std::round(scene.particles)) : nullptr},
           {"fault", scene.fault}});
    json.write(nlohmann::json{{"scenes", array}}.dump(2));
    return ExitCode::good;
  }
  if (scenes.empty()) {
    notice("no scene was found here, in examples/ or beside the program; `pliant new drop` writes one");
    return ExitCode::good;
  }
  std::size_t widest = 0;
  for (const Listed& scene : scenes) widest = std::max(widest, scene.file.string().size());
  std::fputs(fmt::format("{:<{}}  {:>9}\n", "scene", widest, "particles").c_str(), stdout);
  for (const Listed& scene : scenes)
    std::fputs(fmt::format("{:<{}}  {:>9}  {}{}\n", scene.file.string(), widest, about(scene.particles),
                           scene.description,
                           scene.fault.empty()
                               ? ""
                               : fmt::format("{}[{}]", scene.description.empty() ? "" : " ", scene.fault))
                   .c_str(),
               stdout);
  return ExitCode::good;
}

} // namespace

void add_scenes(CLI::App& program, Action& action) {
  CLI::App* command =
      program.add_subcommand("scenes", "list the example scenes and those of the present folder");
  const auto json = std::make_shared<JsonChoice>();
  add_json(*command, *json, "print JSON, or write it to FILE");
  command->footer(R"(Example:
  pliant scenes)");
  command->callback([&action, json] { action = [json] { return list(*json); }; });
}

} // namespace pliant::cli
