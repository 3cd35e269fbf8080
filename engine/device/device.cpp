// Conversions at the border between the engine's doubles and a device's reals.
#include "engine/device/device.h"

#include "engine/core/error.h"

#include <algorithm>
#include <cstring>

namespace pliant {

std::size_t element_bytes(Type type, Precision precision) {
  const std::size_t real = precision == Precision::double_precision ? 8 : 4;
  switch (type) {
  case Type::real:
    return real;
  case Type::real4:
    return 4 * real;
  case Type::uint:
    return 4;
  case Type::uint4:
    return 16;
  }
  return 0;
}

namespace {

void require_range(const BufferStorage* buffer, std::size_t first_byte, std::size_t bytes) {
  if (!buffer) throw Error(ExitCode::internal, "a transfer names a buffer that the plan left out");
  if (first_byte + bytes > buffer->bytes())
    throw Error(ExitCode::internal, "a transfer reaches beyond buffer '" + buffer->name() + "'");
}

// `values` are `count` reals; `first_real` counts reals, whatever the element type.
void write_reals(Device& device, BufferStorage* buffer, const double* values, std::size_t count,
                 std::size_t first_real) {
  if (device.info().precision == Precision::double_precision) {
    require_range(buffer, first_real * 8, count * 8);
    device.write(buffer, first_real * 8, {reinterpret_cast<const std::byte*>(values), count * 8});
    return;
  }
  require_range(buffer, first_real * 4, count * 4);
  std::vector<float> narrow(values, values + count);
  device.write(buffer, first_real * 4, {reinterpret_cast<const std::byte*>(narrow.data()), count * 4});
}

void read_reals(Device& device, const BufferStorage* buffer, double* values, std::size_t count,
                std::size_t first_real) {
  if (device.info().precision == Precision::double_precision) {
    require_range(buffer, first_real * 8, count * 8);
    device.read(buffer, first_real * 8, {reinterpret_cast<std::byte*>(values), count * 8});
    return;
  }
  require_range(buffer, first_real * 4, count * 4);
  std::vector<float> narrow(count);
  device.read(buffer, first_real * 4, {reinterpret_cast<std::byte*>(narrow.data()), count * 4});
  std::copy(narrow.begin(), narrow.end(), values);
}

std::size_t clamp_count(const BufferStorage* buffer, std::size_t first, std::size_t count) {
  return count == SIZE_MAX ? (buffer ? buffer->count() - first : 0) : count;
}

} // namespace

void Device::upload(BufferStorage* buffer, std::span<const double> values, std::size_t first_real) {
  write_reals(*this, buffer, values.data(), values.size(), first_real);
}

void Device::upload(BufferStorage* buffer, std::span<const Real4<double>> values, std::size_t first) {
  write_reals(*this, buffer, reinterpret_cast<const double*>(values.data()), 4 * values.size(), 4 * first);
}

void Device::upload(BufferStorage* buffer, std::span<const std::uint32_t> values, std::size_t first) {
  require_range(buffer, 4 * first, values.size_bytes());
  write(buffer, 4 * first, std::as_bytes(values));
}

std::vector<double> Device::download_real(const BufferStorage* buffer, std::size_t first, std::size_t count) {
  std::vector<double> values(clamp_count(buffer, first, count));
  read_reals(*this, buffer, values.data(), values.size(), first);
  return values;
}

std::vector<Real4<double>> Device::download_real4(const BufferStorage* buffer, std::size_t first,
                                                  std::size_t count) {
  std::vector<Real4<double>> values(clamp_count(buffer, first, count));
  read_reals(*this, buffer, reinterpret_cast<double*>(values.data()), 4 * values.size(), 4 * first);
  return values;
}

std::vector<std::uint32_t> Device::download_uint(const BufferStorage* buffer, std::size_t first,
                                                 std::size_t count) {
  std::vector<std::uint32_t> values(clamp_count(buffer, first, count));
  require_range(buffer, 4 * first, 4 * values.size());
  read(buffer, 4 * first, std::as_writable_bytes(std::span(values)));
  return values;
}

} // namespace pliant
