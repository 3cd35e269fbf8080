// Compiles programs, checks them against their declarations, keeps their binaries on disk.
#include "backends/gl/program.h"

#include "engine/core/error.h"

#include <glad/gl.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <unistd.h>

namespace pliant::gl {

namespace {

namespace fs = std::filesystem;

std::uint64_t fnv1a(std::string_view text, std::uint64_t hash) {
  for (const unsigned char c : text) hash = (hash ^ c) * 1099511628211ull;
  return hash;
}

constexpr std::uint64_t basis = 14695981039346656037ull, other_basis = 0x9e3779b97f4a7c15ull;

// What a cache file begins with; the binary follows.
struct Header {
  char magic[8] = {'P', 'L', 'I', 'A', 'N', 'T', 'P', '1'};
  std::uint32_t format = 0;
  std::uint32_t bytes = 0;
  std::uint64_t sum = 0;
};

std::string cache_path(const Context& context, const Program::Stages& stages) {
  const std::string folder = program_cache_folder();
  GLint formats = 0;
  context.gl().GetIntegerv(GL_NUM_PROGRAM_BINARY_FORMATS, &formats);
  if (folder.empty() || formats < 1) return {};
  std::string key =
      context.vendor() + '\0' + context.renderer() + '\0' + context.version() + '\0' + context.kind();
  for (const auto& [stage, source] : stages) key += '\0' + std::to_string(stage) + '\0' + source.text;
  char name[48];
  std::snprintf(name, sizeof name, "%016llx%016llx.bin", static_cast<unsigned long long>(fnv1a(key, basis)),
                static_cast<unsigned long long>(fnv1a(key, other_basis)));
  return folder + "/" + name;
}

std::string log_of(void (*parameter)(GLuint, GLenum, GLint*),
                   void (*text)(GLuint, GLsizei, GLsizei*, GLchar*), GLuint object) {
  GLint length = 0;
  parameter(object, GL_INFO_LOG_LENGTH, &length);
  std::string log(static_cast<std::size_t>(length > 0 ? length : 1), '\0');
  GLsizei written = 0;
  text(object, static_cast<GLsizei>(log.size()), &written, log.data());
  log.resize(static_cast<std::size_t>(written));
  return log;
}

} // namespace

std::string program_cache_folder() {
  const char* choice = std::getenv("PLIANT_PROGRAM_CACHE");
  if (choice && std::strcmp(choice, "off") == 0) return {};
  const char* cache = std::getenv("XDG_CACHE_HOME");
  if (cache && cache[0] == '/') return std::string(cache) + "/pliant/programs";
  const char* home = std::getenv("HOME");
  return home && home[0] == '/' ? std::string(home) + "/.cache/pliant/programs" : std::string();
}

Program::Program(Context& context, const std::string& what, const Stages& stages) : context_(context) {
  const GladGLContext& gl = context.gl();
  name_ = gl.CreateProgram();
  const std::string path = cache_path(context, stages);
  from_cache_ = !path.empty() && load_binary(path);
  if (from_cache_) return;
  try {
    compile(what, stages);
  } catch (...) {
    gl.DeleteProgram(name_);
    throw;
  }
  if (!path.empty()) save_binary(path);
}

Program::~Program() {
  try {
    const Current current(context_, Current::Restore::foreign);
    context_.gl().DeleteProgram(name_);
  } catch (const Error&) {
    // In use by another thread: the driver frees it with the context.
  }
}

bool Program::load_binary(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  Header header;
  const Header expected;
  if (bytes.size() < sizeof header) return false;
  std::memcpy(&header, bytes.data(), sizeof header);
  const std::string_view binary = std::string_view(bytes).substr(sizeof header);
  if (std::memcmp(header.magic, expected.magic, sizeof header.magic) != 0 || header.bytes != binary.size() ||
      header.sum != fnv1a(binary, basis))
    return false;
  const GladGLContext& gl = context_.gl();
  gl.ProgramBinary(name_, header.format, binary.data(), static_cast<GLsizei>(binary.size()));
  GLint linked = GL_FALSE;
  gl.GetProgramiv(name_, GL_LINK_STATUS, &linked);
  while (gl.GetError() != GL_NO_ERROR) {
  } // a refused binary is no fault: the text is compiled instead
  return linked == GL_TRUE;
}

// Written under a name of its own and renamed: another process never sees half a file. A cache that cannot be
// written costs time, not results, so nothing is reported.
void Program::save_binary(const std::string& path) const {
  const GladGLContext& gl = context_.gl();
  GLint length = 0;
  gl.GetProgramiv(name_, GL_PROGRAM_BINARY_LENGTH, &length);
  if (length <= 0) return;
  std::string binary(static_cast<std::size_t>(length), '\0');
  Header header;
  GLenum format = 0;
  GLsizei written = 0;
  gl.GetProgramBinary(name_, length, &written, &format, binary.data());
  if (gl.GetError() != GL_NO_ERROR || written <= 0) return;
  binary.resize(static_cast<std::size_t>(written));
  header.format = format;
  header.bytes = static_cast<std::uint32_t>(binary.size());
  header.sum = fnv1a(binary, basis);

  static std::atomic<unsigned> serial{0};
  const std::string temporary = path + "." + std::to_string(getpid()) + "." + std::to_string(serial++);
  std::error_code failed;
  fs::create_directories(fs::path(path).parent_path(), failed);
  bool good = false;
  {
    std::ofstream file(temporary, std::ios::binary);
    file.write(reinterpret_cast<const char*>(&header), sizeof header);
    file.write(binary.data(), static_cast<std::streamsize>(binary.size()));
    file.close();
    good = file.good();
  }
  if (good) fs::rename(temporary, path, failed);
  if (!good || failed) fs::remove(temporary, failed);
}

void Program::compile(const std::string& what, const Stages& stages) {
  const GladGLContext& gl = context_.gl();
  std::vector<GLuint> shaders;
  std::string fault;
  for (const auto& [stage, source] : stages) {
    const GLuint shader = gl.CreateShader(stage);
    shaders.push_back(shader);
    const char* text = source.text.c_str();
    gl.ShaderSource(shader, 1, &text, nullptr);
    gl.CompileShader(shader);
    GLint compiled = GL_FALSE;
    gl.GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    if (compiled != GL_TRUE)
      fault += "shader " + what + " does not compile on " + context_.renderer() + ":\n" +
               readable_log(log_of(gl.GetShaderiv, gl.GetShaderInfoLog, shader), source);
    gl.AttachShader(name_, shader);
  }
  if (fault.empty()) {
    gl.ProgramParameteri(name_, GL_PROGRAM_BINARY_RETRIEVABLE_HINT, GL_TRUE);
    gl.LinkProgram(name_);
    GLint linked = GL_FALSE;
    gl.GetProgramiv(name_, GL_LINK_STATUS, &linked);
    if (linked != GL_TRUE)
      fault = "shader " + what + " does not link on " + context_.renderer() + ":\n" +
              readable_log(log_of(gl.GetProgramiv, gl.GetProgramInfoLog, name_), stages.back().second);
  }
  for (const GLuint shader : shaders) {
    gl.DetachShader(name_, shader);
    gl.DeleteShader(shader);
  }
  if (!fault.empty()) throw Error(ExitCode::internal, fault);
}

namespace {

[[noreturn]] void disagree(const KernelInfo& kernel, const std::string& what) {
  throw Error(ExitCode::internal, std::string("kernel '") + kernel.name +
                                      "': the driver disagrees with its "
                                      "declaration: " +
                                      what);
}

GLint property(const GladGLContext& gl, GLuint program, GLenum interface, GLuint index, GLenum name) {
  GLint value = -1;
  gl.GetProgramResourceiv(program, interface, index, 1, &name, 1, nullptr, &value);
  return value;
}

} // namespace

KernelProgram::KernelProgram(Context& context, const KernelInfo& kernel, const void* args, const Texts& texts)
    : source_(expand_kernel(kernel, args, texts)),
      program_(context, variant_name(kernel, args), {{GL_COMPUTE_SHADER, source_}}) {
  const GladGLContext& gl = context.gl();
  const std::string prefix = std::string(kernel.name) + "_";
  // A name that the driver does not report was optimised away, and there is nothing to check.
  const auto find = [&](GLenum interface, const std::string& block) {
    return gl.GetProgramResourceIndex(name(), interface, block.c_str());
  };

  const GLuint parameters = find(GL_UNIFORM_BLOCK, prefix + "parameters");
  if (parameters != GL_INVALID_INDEX) {
    const auto bytes = property(gl, name(), GL_UNIFORM_BLOCK, parameters, GL_BUFFER_DATA_SIZE);
    const auto ours = static_cast<GLint>(parameter_bytes(kernel));
    if (bytes != ours && bytes != (ours + 15) / 16 * 16) // drivers may round a block up to a group of four
      disagree(kernel, "parameters of " + std::to_string(bytes) + " bytes, not " + std::to_string(ours));
    if (property(gl, name(), GL_UNIFORM_BLOCK, parameters, GL_BUFFER_BINDING) !=
        static_cast<GLint>(parameter_slot))
      disagree(kernel, "the slot of the parameters");
  }
  GLint offset = 4;
  for (const Field& field : kernel.fields) {
    if (field.role == Role::parameter) {
      const GLuint member = find(GL_UNIFORM, field.name);
      if (member != GL_INVALID_INDEX && property(gl, name(), GL_UNIFORM, member, GL_OFFSET) != offset)
        disagree(kernel, std::string("the place of parameter '") + field.name + "'");
      offset += 4;
    }
    if (field.role == Role::parameter || field.role == Role::option || !uses(field)) continue;
    const GLenum interface = field.role == Role::table ? GL_UNIFORM_BLOCK : GL_SHADER_STORAGE_BLOCK;
    const GLuint block = find(interface, prefix + field.name + "_block");
    if (block == GL_INVALID_INDEX) continue;
    if (property(gl, name(), interface, block, GL_BUFFER_BINDING) != static_cast<GLint>(field.slot))
      disagree(kernel, std::string("the slot of '") + field.name + "'");
    if (field.role == Role::table &&
        property(gl, name(), interface, block, GL_BUFFER_DATA_SIZE) != static_cast<GLint>(16 * field.size))
      disagree(kernel, std::string("the size of table '") + field.name + "'");
  }
}

} // namespace pliant::gl
