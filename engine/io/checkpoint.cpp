// Checkpoints as HDF5.
#include "engine/io/checkpoint.h"

#include "engine/core/error.h"
#include "engine/io/hdf5.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <unistd.h>

namespace pliant {

namespace fs = std::filesystem;

namespace {

constexpr std::uint64_t format = 1;
constexpr std::size_t kept_checkpoints = 2;
constexpr std::array type_names = {std::pair{Type::real, "real"}, std::pair{Type::real4, "real4"},
                                   std::pair{Type::uint, "uint"}, std::pair{Type::uint4, "uint4"}};

std::string name_of(Type type) {
  for (const auto& [value, name] : type_names)
    if (value == type) return name;
  throw Error(ExitCode::internal, "a buffer of a type that checkpoints do not store");
}

Type type_of(const std::string& wanted) {
  for (const auto& [value, name] : type_names)
    if (wanted == name) return value;
  throw Error(ExitCode::input_output, fmt::format("'{}' is no type of buffer", wanted));
}

[[noreturn]] void fail(const std::string& doing, const fs::path& path) {
  throw Error(ExitCode::input_output,
              fmt::format("cannot {} {}: {}", doing, path.string(), std::strerror(errno)));
}

void sync(const fs::path& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) fail("open", path);
  const bool done = ::fsync(file) == 0 || errno == EINVAL; // some file systems cannot sync a folder
  ::close(file);
  if (!done) fail("write", path);
}

nlohmann::json record_of(const Checkpoint& c) {
  nlohmann::json buffers = nlohmann::json::array();
  for (const SavedBuffer& buffer : c.state.buffers)
    buffers.push_back({{"name", buffer.name}, {"type", name_of(buffer.type)}});
  nlohmann::json j = {{"version", PLIANT_VERSION},
                      {"scene", c.identity.scene},
                      {"build", c.identity.build},
                      {"backend", c.identity.backend},
                      {"device", c.identity.device},
                      {"driver", c.identity.driver},
                      {"precision", c.identity.precision},
                      {"step", c.state.step},
                      {"first_of_bdf2", c.state.first_of_bdf2},
                      {"buffers", buffers},
                      {"frames", c.progress.frames},
                      {"statistics_bytes", c.progress.statistics_bytes},
                      {"wall_seconds", c.progress.wall_seconds},
                      {"retries", c.progress.retries},
                      {"divided_steps", c.progress.divided_steps},
                      {"pictures", c.progress.pictures}};
  if (c.progress.data)
    j["data"] = {{"frames", c.progress.data->frames},
                 {"next_frame", c.progress.data->next_frame},
                 {"size", c.progress.data->size}};
  return j;
}

std::uint64_t checksum(const std::string& record, const Checkpoint& c) {
  Fingerprint print;
  print.add(record);
  for (const SavedBuffer& buffer : c.state.buffers) print.add(buffer.bytes);
  if (c.progress.data) {
    print.add(std::as_bytes(std::span(c.progress.data->bulk)));
    print.add(std::as_bytes(std::span(c.progress.data->rest)));
  }
  return print.value();
}

/// The checkpoints of a run, newest first.
std::vector<std::pair<std::uint64_t, fs::path>> checkpoints_of(const fs::path& folder) {
  std::vector<std::pair<std::uint64_t, fs::path>> found;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder / "checkpoints", error)) {
    const std::string name = entry.path().filename().string();
    if (name.rfind("step-", 0) != 0 || entry.path().extension() != ".h5") continue;
    const std::string digits = name.substr(5, name.size() - 8);
    if (digits.empty() || digits.size() > 18 || digits.find_first_not_of("0123456789") != std::string::npos)
      continue;
    found.emplace_back(std::stoull(digits), entry.path());
  }
  std::sort(found.rbegin(), found.rend());
  return found;
}

void write_content(const fs::path& path, const Checkpoint& c) {
  h5::File file = h5::File::create(path);
  std::uint64_t room = 1 << 16;
  for (const SavedBuffer& buffer : c.state.buffers) room += buffer.bytes.size() + 4096;
  if (c.progress.data) room += c.progress.data->rest.size() + 16 * c.progress.data->bulk.size();
  file.reserve(room);
  {
    h5::Group root = file.root();
    const std::string record = record_of(c).dump();
    root.set_attribute("format", format);
    root.set_text_attribute("record", record);
    root.set_attribute("checksum", checksum(record, c));
    for (const SavedBuffer& buffer : c.state.buffers)
      root.write("state/" + buffer.name,
                 std::span(reinterpret_cast<const std::uint8_t*>(buffer.bytes.data()), buffer.bytes.size()));
    if (c.progress.data) {
      const RunMark& mark = *c.progress.data;
      std::vector<std::uint64_t> bulk;
      for (const auto& piece : mark.bulk) bulk.insert(bulk.end(), piece.begin(), piece.end());
      root.write("data/bulk", std::span<const std::uint64_t>(bulk));
      root.write("data/rest", std::span<const std::uint8_t>(mark.rest));
    }
  }
  file.close();
}

Checkpoint read_content(const fs::path& path) {
  const h5::File file = h5::File::open(path);
  const h5::Group root = file.root();
  const std::uint64_t written = root.attribute<std::uint64_t>("format").at(0);
  if (written != format)
    throw Error(ExitCode::usage, // told apart from damage
                fmt::format("{} is of format {}, and this program reads {}: it is of another build",
                            path.string(), written, format));
  const std::string record = root.text_attribute("record");
  const nlohmann::json j = nlohmann::json::parse(record);
  Checkpoint c;
  c.identity = {j.at("scene"),  j.at("build"),  j.at("backend"),
                j.at("device"), j.at("driver"), j.at("precision")};
  c.state.step = j.at("step");
  c.state.first_of_bdf2 = j.at("first_of_bdf2");
  for (const nlohmann::json& buffer : j.at("buffers")) {
    SavedBuffer copy{buffer.at("name"), type_of(buffer.at("type")), {}};
    const std::vector<std::uint8_t> bytes = root.read<std::uint8_t>("state/" + copy.name);
    const auto* first = reinterpret_cast<const std::byte*>(bytes.data());
    copy.bytes.assign(first, first + bytes.size());
    c.state.buffers.push_back(std::move(copy));
  }
  RunProgress& p = c.progress;
  p.frames = j.at("frames");
  p.statistics_bytes = j.at("statistics_bytes");
  p.wall_seconds = j.at("wall_seconds");
  p.retries = j.at("retries");
  p.divided_steps = j.at("divided_steps");
  p.pictures = j.at("pictures");
  if (j.contains("data")) {
    RunMark mark{j["data"].at("frames"), j["data"].at("next_frame"), j["data"].at("size"), {}, {}};
    const std::vector<std::uint64_t> bulk = root.read<std::uint64_t>("data/bulk");
    for (std::size_t k = 0; k + 1 < bulk.size(); k += 2) mark.bulk.push_back({bulk[k], bulk[k + 1]});
    mark.rest = root.read<std::uint8_t>("data/rest");
    p.data = std::move(mark);
  }
  if (checksum(record, c) != root.attribute<std::uint64_t>("checksum").at(0))
    throw Error(ExitCode::input_output, "its checksum does not fit its contents");
  return c;
}

/// Which of them it is, in words; empty where it is the same.
std::string difference(const CheckpointIdentity& made, const CheckpointIdentity& here) {
  if (made.scene != here.scene)
    return "it is foreign: of another scene, or the scene or a mesh has changed since. Resume with the scene "
           "and the --set and --solver of the start";
  if (made.build != here.build)
    return fmt::format("it is of another build of pliant ({}, this is {}), whose bits may differ", made.build,
                       here.build);
  const auto words = [](const CheckpointIdentity& i) {
    return fmt::format("{} on {} ({}), {}", i.backend, i.device, i.driver, i.precision);
  };
  if (made != here)
    return fmt::format("it is of another device: {}, not {}. Choose it with --backend and --precision",
                       words(made), words(here));
  return "";
}

} // namespace

void write_checkpoint(const fs::path& folder, const Checkpoint& checkpoint) {
  const fs::path place = folder / "checkpoints";
  std::error_code error;
  fs::create_directories(place, error);
  if (error)
    throw Error(ExitCode::input_output, fmt::format("cannot make {}: {}", place.string(), error.message()));
  const fs::path file = place / fmt::format("step-{:08}.h5", checkpoint.state.step);
  const fs::path draft = file.string() + ".tmp";
  try {
    write_content(draft, checkpoint);
    sync(draft);
    if (::rename(draft.c_str(), file.c_str()) != 0) fail("write", file);
  } catch (...) {
    fs::remove(draft, error);
    throw;
  }
  sync(place);
  const auto all = checkpoints_of(folder);
  for (std::size_t k = kept_checkpoints; k < all.size(); ++k) fs::remove(all[k].second, error);
}

Checkpoint read_checkpoint(const fs::path& file) {
  const auto damaged = [&](const char* why) {
    return Error(ExitCode::input_output, fmt::format("the checkpoint {} is damaged: {}", file.string(), why));
  };
  try {
    return read_content(file);
  } catch (const Error& error) {
    if (error.code() == ExitCode::usage) throw Error(ExitCode::input_output, error.what());
    throw damaged(error.what());
  } catch (const std::exception& error) { // JSON, or sizes that no memory holds
    throw damaged(error.what());
  }
}

std::optional<Checkpoint> find_checkpoint(const fs::path& folder, const CheckpointIdentity& wanted,
                                          const std::function<void(const std::string&)>& say) {
  const auto all = checkpoints_of(folder);
  std::string complaint;
  for (const auto& [step, file] : all) {
    std::optional<Checkpoint> found;
    try {
      found = read_checkpoint(file);
    } catch (const Error& error) {
      if (complaint.empty()) complaint = error.what();
      continue;
    }
    if (const std::string why = difference(found->identity, wanted); !why.empty())
      throw Error(ExitCode::input_output, fmt::format("cannot resume from {}: {}", file.string(), why));
    if (!complaint.empty()) say(fmt::format("{}; going on from {}", complaint, file.string()));
    return found;
  }
  if (!all.empty())
    throw Error(ExitCode::input_output,
                fmt::format("{}; there is no other. Start the run anew in another folder", complaint));
  return std::nullopt;
}

void drop_checkpoints_after(const fs::path& folder, std::uint64_t step) {
  std::error_code error;
  for (const auto& [other, file] : checkpoints_of(folder))
    if (other > step) fs::remove(file, error);
}

void Fingerprint::add(std::span<const std::byte> bytes) {
  const auto mix = [this](std::uint64_t word) { value_ = (value_ ^ word) * 0x100000001b3u; };
  std::size_t at = 0;
  for (std::uint64_t word = 0; at + sizeof word <= bytes.size(); at += sizeof word) {
    std::memcpy(&word, bytes.data() + at, sizeof word);
    mix(word);
  }
  for (; at < bytes.size(); ++at) mix(static_cast<std::uint64_t>(bytes[at]));
  mix(bytes.size());
}

std::string Fingerprint::text() const {
  return fmt::format("{:016x}", value_);
}

const std::string& build_fingerprint() {
  static const std::string text = [] {
    Fingerprint print;
    print.add(std::string(PLIANT_VERSION));
    std::ifstream program("/proc/self/exe", std::ios::binary);
    std::vector<char> block(std::size_t{1} << 20);
    while (program.read(block.data(), static_cast<std::streamsize>(block.size())) || program.gcount() > 0)
      print.add(std::as_bytes(std::span(block)).first(static_cast<std::size_t>(program.gcount())));
    return print.text();
  }();
  return text;
}

} // namespace pliant
