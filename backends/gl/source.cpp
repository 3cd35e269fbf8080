// Writes the GLSL side of a kernel's declaration and expands its text.
#include "backends/gl/source.h"

#include "backends/gl/shader_text.h"
#include "engine/core/error.h"

#include <algorithm>
#include <cctype>
#include <cstring>
#include <sstream>

namespace pliant::gl {

namespace {

const char* type_name(Type type) {
  switch (type) {
  case Type::real: return "real";
  case Type::real4: return "real4";
  case Type::uint: return "uint";
  case Type::uint4: return "uint4";
  }
  return "";
}

[[noreturn]] void fail(const KernelInfo& kernel, const std::string& what) {
  throw Error(ExitCode::internal, std::string("kernel '") + kernel.name + "': " + what);
}

std::uint32_t option_value(const Field& field, const void* args) {
  std::uint32_t value = 0;
  std::memcpy(&value, static_cast<const char*>(args) + field.offset, sizeof value);
  return value;
}

std::string interface_text(const KernelInfo& kernel, const void* args) {
  std::ostringstream out;
  out << "#version 430 core\n#define real float\n#define real4 vec4\n#define uint4 uvec4\n#define GROUP "
      << kernel.group_size << "u\nlayout(local_size_x = " << kernel.group_size << ") in;\n";
  for (const Field& field : kernel.fields)
    if (field.role == Role::option) out << "#define " << field.name << " " << option_value(field, args) << "\n";
  out << "layout(std140, binding = " << parameter_slot << ") uniform " << kernel.name
      << "_parameters {\n  uint threads;\n";
  for (const Field& field : kernel.fields) {
    if (field.role != Role::parameter) continue;
    if (field.type != Type::real && field.type != Type::uint)
      fail(kernel, std::string("parameter '") + field.name + "' is not a scalar");
    out << "  " << type_name(field.type) << " " << field.name << ";\n";
  }
  out << "};\n";
  std::uint32_t buffers = 0;
  for (const Field& field : kernel.fields) {
    if (field.role == Role::option || field.role == Role::parameter) continue;
    if (field.role == Role::table) {
      // std140 would pad each scalar of an array to 16 bytes.
      if (field.type != Type::real4 && field.type != Type::uint4)
        fail(kernel, std::string("table '") + field.name + "' must hold real4 or uint4");
      if (field.slot >= parameter_slot) fail(kernel, std::string("table '") + field.name + "' has a slot too high");
      out << "layout(std140, binding = " << field.slot << ") uniform " << kernel.name << "_" << field.name
          << "_block { " << type_name(field.type) << " " << field.name << "[" << field.size << "]; };\n";
      continue;
    }
    if (++buffers > max_buffers || field.slot >= max_buffers)
      fail(kernel, "more than 8 storage buffers, which is all that OpenGL 4.3 promises");
    // An output is not writeonly: a shader may read back what it wrote.
    out << "layout(std430, binding = " << field.slot << ") restrict " << (field.role == Role::in ? "readonly " : "")
        << "buffer " << kernel.name << "_" << field.name << "_block { " << type_name(field.type) << " " << field.name
        << "[]; };\n";
  }
  return out.str();
}

// The file named by a line such as `#include "common/tensor.glsl"`, or nothing.
std::string included_file(const std::string& line) {
  std::size_t at = line.find_first_not_of(" \t");
  if (at == std::string::npos || line[at] != '#') return {};
  at = line.find_first_not_of(" \t", at + 1);
  if (at == std::string::npos || line.compare(at, 7, "include") != 0) return {};
  const std::size_t open = line.find('"', at), close = open == std::string::npos ? open : line.find('"', open + 1);
  return close == std::string::npos ? std::string() : line.substr(open + 1, close - open - 1);
}

} // namespace

void append_file(Source& source, const std::string& name, const Texts& texts) {
  const auto file = texts.find(name);
  if (file == texts.end()) throw Error(ExitCode::internal, "shader file '" + name + "' is not in this build");
  const std::size_t number = source.files.size();
  source.files.push_back(name);
  const auto mark = [&](std::size_t line) {
    source.text += "#line " + std::to_string(line) + " " + std::to_string(number) + "\n";
  };
  mark(1);
  std::istringstream in(file->second);
  std::string line;
  for (std::size_t count = 1; std::getline(in, line); ++count) {
    const std::string included = included_file(line);
    if (included.empty()) {
      source.text += line + "\n";
      continue;
    }
    if (std::find(source.files.begin(), source.files.end(), included) == source.files.end()) {
      if (!texts.count(included))
        throw Error(ExitCode::internal,
                    name + ":" + std::to_string(count) + ": shader file '" + included + "' is not in this build");
      append_file(source, included, texts);
    }
    mark(count + 1);
  }
}

Source expand_kernel(const KernelInfo& kernel, const void* args, const Texts& texts) {
  Source source;
  source.text = interface_text(kernel, args);
  source.files.push_back(std::string("interface of ") + kernel.name);
  append_file(source, "common/threads.glsl", texts);
  append_file(source, std::string(kernel.name) + ".comp", texts);
  return source;
}

std::string readable_log(const std::string& log, const Source& source) {
  std::istringstream in(log);
  std::string result, line;
  const auto digits = [&](std::size_t from) {
    while (from < line.size() && std::isdigit(static_cast<unsigned char>(line[from]))) ++from;
    return from;
  };
  while (std::getline(in, line)) {
    // Mesa: "0:12(5): error: …"; NVIDIA: "0(12) : error …"; others: "ERROR: 0:12: …".
    std::size_t from = 0;
    for (const char* word : {"ERROR: ", "WARNING: "})
      if (line.rfind(word, 0) == 0) from = std::strlen(word);
    const std::size_t end = digits(from);
    const bool numbered = end > from && end - from < 6 && end + 1 < line.size() &&
                          (line[end] == ':' || line[end] == '(') && digits(end + 1) > end + 1;
    const std::size_t file = numbered ? std::stoul(line.substr(from, end - from)) : source.files.size();
    if (file < source.files.size()) {
      const std::size_t last = digits(end + 1);
      const std::size_t rest = line[end] == '(' && last < line.size() ? last + 1 : last;
      result += line.substr(0, from) + source.files[file] + ":" + line.substr(end + 1, last - end - 1) +
                line.substr(rest) + "\n";
    } else {
      result += line + "\n";
    }
  }
  return result;
}

std::string variant_name(const KernelInfo& kernel, const void* args) {
  std::string options;
  for (const Field& field : kernel.fields) {
    if (field.role != Role::option) continue;
    options.append(options.empty() ? "" : ",").append(field.name).append("=");
    options.append(std::to_string(option_value(field, args)));
  }
  return options.empty() ? kernel.name : std::string(kernel.name).append("[").append(options).append("]");
}

std::size_t parameter_bytes(const KernelInfo& kernel) {
  return 4 * (1 + std::count_if(kernel.fields.begin(), kernel.fields.end(),
                                [](const Field& field) { return field.role == Role::parameter; }));
}

std::string expanded_source(const KernelInfo& kernel, const void* args) {
  return expand_kernel(kernel, args, shader_texts()).text;
}

} // namespace pliant::gl
