// Looks at devices, libraries, meshes and caches; prints what it found.
#include "engine/report/doctor.h"

#include "engine/core/error.h"
#include "engine/io/film.h"
#include "engine/io/library_versions.h"
#include "engine/scene/mesh.h"

#include <Eigen/Core>
#include <cstdlib>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace pliant {

namespace {

namespace fs = std::filesystem;

constexpr const char* example_meshes[] = {"armadillo.off", "bunny00.off"};

bool is_folder(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

Diagnosis::Backend look_at(DeviceListing listing) {
  Diagnosis::Backend backend{std::move(listing), 0, 0};
  if (!backend.listing.usable) return backend;
  try {
    DeviceRequest request;
    request.backend = backend.listing.backend;
    if (request.backend == "gl") request.backend += fmt::format(":{}", backend.listing.index);
    const std::unique_ptr<Device> device = open_device(request);
    backend.max_buffer_bytes = device->info().max_buffer_bytes;
    if (backend.listing.backend == "openmp") backend.threads = device->info().threads;
  } catch (const Error& error) {
    backend.listing.usable = false;
    backend.listing.missing = error.what();
  }
  return backend;
}

/// Where compiled GPU programs are kept; the GL backend's own rule.
Diagnosis::Folder program_cache() {
  Diagnosis::Folder folder{"compiled GPU programs", {}, false};
  const char* choice = std::getenv("PLIANT_PROGRAM_CACHE");
  if (choice && std::string(choice) == "off") return folder;
  const char* cache = std::getenv("XDG_CACHE_HOME");
  const char* home = std::getenv("HOME");
  if (cache && cache[0] == '/')
    folder.path = fs::path(cache) / "pliant" / "programs";
  else if (home && home[0] == '/')
    folder.path = fs::path(home) / ".cache" / "pliant" / "programs";
  folder.exists = is_folder(folder.path);
  return folder;
}

std::string bytes_text(std::size_t bytes) {
  if (bytes == SIZE_MAX) return "as memory allows";
  return bytes >= (std::size_t{1} << 30) ? fmt::format("{:.4g} GiB", double(bytes) / (1 << 30))
                                         : fmt::format("{:.4g} MiB", double(bytes) / (1 << 20));
}

} // namespace

Diagnosis diagnose() {
  Diagnosis found;
  bool any_gl = false;
  for (DeviceListing& listing : list_devices()) {
    found.backends.push_back(look_at(std::move(listing)));
    const DeviceListing& seen = found.backends.back().listing;
    if (seen.backend == "gl" && seen.usable) any_gl = true;
    if (!seen.usable && !seen.missing.empty())
      found.advice.push_back(fmt::format("{} ({}): {}", seen.backend, seen.name, seen.missing));
  }
  if (!any_gl)
    found.advice.push_back("without a GL device there are no pictures (a software one will do: libegl1 and "
                           "libgl1-mesa-dri); `pliant run --no-render` does without");
  found.libraries = {
      {"HDF5", hdf5_version()},
      {"libpng", png_version()},
      {"fmt", fmt::format("{}.{}.{}", FMT_VERSION / 10000, FMT_VERSION / 100 % 100, FMT_VERSION % 100)},
      {"Eigen", fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
      {"nlohmann-json", fmt::format("{}.{}.{}", NLOHMANN_JSON_VERSION_MAJOR, NLOHMANN_JSON_VERSION_MINOR,
                                    NLOHMANN_JSON_VERSION_PATCH)}};
  found.film_encoder = film_encoder();
  if (found.film_encoder.empty())
    found.advice.push_back(
        "films: no ffmpeg with a video encoder; install ffmpeg (Debian), or leave out --video");
  for (const fs::path& folder : mesh_folders({}))
    found.mesh_folders.push_back({"meshes", folder, is_folder(folder)});
  found.mesh_folders.front().use = "meshes: beside the scene (here: the present folder)";
  for (const char* name : example_meshes) {
    Diagnosis::MeshFile mesh{name, {}};
    try {
      mesh.file = find_mesh(name, {});
    } catch (const Error&) { // not found: said below
    }
    if (mesh.file.empty())
      found.advice.push_back(
          fmt::format("mesh {}: fetch it with `examples/main-job.sh --meshes` (from Debian's "
                      "package libcgal-demo), or put it in a folder named by PLIANT_MESHES",
                      name));
    found.meshes.push_back(std::move(mesh));
  }
  found.caches.push_back(program_cache());
  return found;
}

std::string diagnosis_text(const Diagnosis& diagnosis) {
  std::string text = "pliant " PLIANT_VERSION "\n\nBackends\n";
  for (const Diagnosis::Backend& backend : diagnosis.backends) {
    const DeviceListing& one = backend.listing;
    const std::string name =
        one.backend == "gl" && one.usable ? fmt::format("gl:{}", one.index) : one.backend;
    text += fmt::format("  {:<9}{}{}\n", name, one.name,
                        one.software ? " (software: it runs on the processor)" : "");
    if (!one.driver.empty()) text += fmt::format("           {}\n", one.driver);
    if (one.usable) {
      text += fmt::format("           largest buffer: {}", bytes_text(backend.max_buffer_bytes));
      if (backend.threads > 0) text += fmt::format("; threads: {}", backend.threads);
      text += '\n';
    } else {
      text += fmt::format("           not usable: {}\n", one.missing);
    }
  }
  text += "\nLibraries\n";
  for (const Diagnosis::Library& library : diagnosis.libraries)
    text += fmt::format("  {:<15}{}\n", library.name, library.version);
  text += fmt::format("  {:<15}{}\n", "ffmpeg",
                      diagnosis.film_encoder.empty() ? "not found"
                                                     : "found, encodes with " + diagnosis.film_encoder);
  text += "\nMeshes are sought in\n";
  for (const Diagnosis::Folder& folder : diagnosis.mesh_folders)
    text += fmt::format("  {}{}\n", folder.path.string(),
                        folder.path == "." ? " (the scene's own folder)"
                        : folder.exists    ? ""
                                           : " (not there)");
  for (const Diagnosis::MeshFile& mesh : diagnosis.meshes)
    text += fmt::format("  {:<15}{}\n", mesh.name, mesh.file.empty() ? "not found" : mesh.file.string());
  text += "\nCaches\n";
  for (const Diagnosis::Folder& folder : diagnosis.caches)
    text += fmt::format(
        "  {}: {}\n", folder.use,
        folder.path.empty() ? "off" : folder.path.string() + (folder.exists ? "" : " (not there yet)"));
  text += diagnosis.advice.empty() ? "\nNothing is missing.\n" : "\nMissing\n";
  for (const std::string& line : diagnosis.advice) text += fmt::format("  - {}\n", line);
  return text;
}

nlohmann::json diagnosis_json(const Diagnosis& diagnosis) {
  using nlohmann::json;
  json result = {{"version", PLIANT_VERSION}, {"backends", json::array()}, {"libraries", json::object()}};
  for (const Diagnosis::Backend& backend : diagnosis.backends) {
    const DeviceListing& one = backend.listing;
    json entry = {{"backend", one.backend},   {"name", one.name},     {"driver", one.driver},
                  {"software", one.software}, {"usable", one.usable}, {"missing", one.missing}};
    if (one.backend == "gl") entry["index"] = one.index;
    if (backend.threads > 0) entry["threads"] = backend.threads;
    entry["max_buffer_bytes"] = nullptr; // null: unknown, or limited by memory alone
    if (backend.max_buffer_bytes > 0 && backend.max_buffer_bytes != SIZE_MAX)
      entry["max_buffer_bytes"] = backend.max_buffer_bytes;
    result["backends"].push_back(std::move(entry));
  }
  for (const Diagnosis::Library& library : diagnosis.libraries)
    result["libraries"][library.name] = library.version;
  result["film"] = {{"usable", !diagnosis.film_encoder.empty()},
                    {"encoder", diagnosis.film_encoder},
                    {"missing", diagnosis.film_encoder.empty() ? "ffmpeg" : ""}};
  const auto folders = [](const std::vector<Diagnosis::Folder>& list) {
    json array = json::array();
    for (const Diagnosis::Folder& folder : list)
      array.push_back({{"use", folder.use}, {"path", folder.path.string()}, {"exists", folder.exists}});
    return array;
  };
  result["mesh_folders"] = folders(diagnosis.mesh_folders);
  result["caches"] = folders(diagnosis.caches);
  result["meshes"] = json::array();
  for (const Diagnosis::MeshFile& mesh : diagnosis.meshes)
    result["meshes"].push_back(
        {{"name", mesh.name}, {"file", mesh.file.string()}, {"found", !mesh.file.empty()}});
  result["missing"] = diagnosis.advice;
  return result;
}

} // namespace pliant
