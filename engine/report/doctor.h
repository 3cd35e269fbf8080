// What this machine offers to Pliant, and what to install for the rest.
#pragma once

#include "engine/device/device.h"

#include <nlohmann/json_fwd.hpp>

#include <filesystem>
#include <string>
#include <vector>

namespace pliant {

struct Diagnosis {
  struct Backend {
    DeviceListing listing;
    std::size_t max_buffer_bytes = 0; ///< largest single buffer; 0: unknown, SIZE_MAX: memory alone limits it
    unsigned threads = 0;             ///< openmp
  };
  struct Library {
    std::string name, version;
  };
  struct MeshFile {
    std::string name;
    std::filesystem::path file; ///< empty: not found
  };
  struct Folder {
    std::string use;
    std::filesystem::path path; ///< empty: there is none
    bool exists = false;
  };
  std::vector<Backend> backends;
  std::vector<Library> libraries;
  std::string film_encoder;                 ///< "" without ffmpeg
  std::vector<Folder> mesh_folders, caches; ///< in the order in which they are searched
  std::vector<MeshFile> meshes;             ///< those that the example scenes use
  std::vector<std::string> advice;          ///< one line for each thing missing, naming the package
};

/// Opens every device once to learn its limits.
Diagnosis diagnose();
std::string diagnosis_text(const Diagnosis& diagnosis);
/// {version, backends [{backend, name, software, usable, missing, ...}], libraries, film, meshes, ...}.
nlohmann::json diagnosis_json(const Diagnosis& diagnosis);

} // namespace pliant
