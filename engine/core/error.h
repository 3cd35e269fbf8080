// What every failure of Pliant looks like: an exit code for programs, a sentence for people.
#pragma once

#include <stdexcept>
#include <string>

namespace pliant {

/// How the program ends. The numbers are part of its interface.
enum class ExitCode : int {
  good = 0,
  internal = 1,     ///< a fault of Pliant's own
  usage = 2,        ///< the command line or the scene is wrong
  no_device = 3,    ///< the device asked for does not exist here
  diverged = 4,     ///< the simulation left the finite numbers; the last good state is kept
  input_output = 5, ///< a file could not be read or written
  too_large = 6,    ///< the scene does not fit the device
  interrupted = 130 ///< stopped by the user, after a flush
};

/// A failure that says what happened, where, and what to do.
class Error : public std::runtime_error {
public:
  Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ExitCode code() const noexcept { return code_; }

private:
  ExitCode code_;
};

} // namespace pliant
