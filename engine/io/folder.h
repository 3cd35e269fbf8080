// The folder of a run, and text files that are never half there.
#pragma once

#include <filesystem>
#include <string>

namespace pliant {

/// Makes an output folder and those above it, or accepts an empty one.
/// Throws Error(input_output): something lies in it, it is a file, or it cannot be made or written to.
void prepare_output_folder(const std::filesystem::path& folder);

/// Replaces a text file in one rename: readers see the old text or the new one. What is no file (a pipe,
/// /dev/null) is written into. Throws Error(input_output).
void write_text_file(const std::filesystem::path& path, const std::string& text);
/// Throws Error(input_output).
std::string read_text_file(const std::filesystem::path& path);

} // namespace pliant
