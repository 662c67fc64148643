#pragma once

#include <optional>
#include <string>

namespace bearing_calibration {

/// Writes `text` to the file at `path` so that whoever reads it, at any moment and after any crash,
/// finds either the file of before or the whole new one: a temporary file in the same folder is
/// written, synchronised with the disk and renamed. Missing folders are made.
/// @returns what went wrong, with the path; nothing when the file is written.
std::optional<std::string> writeFileAtomically(const std::string& path, const std::string& text);

}  // namespace bearing_calibration
