#pragma once

#include <boost/program_options.hpp>
#include <functional>
#include <optional>
#include <string>

namespace bearing_calibration::core {

inline constexpr int kUsageError = 2;  ///< exit status for wrong arguments

/// What main() does in the programs of this folder: runs `work`, and says in one line why it
/// failed.
/// @returns what `work` returns; kUsageError for an error of boost::program_options;
///   `failure_status` for any other exception
int runProgram(const char* name, const std::function<int()>& work, int failure_status = 1);

/// The arguments by their names, stored where the options say. None when only help was asked for,
/// which is printed then.
/// @param visible  options, as --help shows them
/// @param hidden  what `positions` names
/// @throws boost::program_options::error
std::optional<boost::program_options::variables_map> parseArguments(
    int argc, char** argv, const boost::program_options::options_description& visible,
    const boost::program_options::options_description& hidden = {},
    const boost::program_options::positional_options_description& positions = {});

/// @param option  its name without the dashes
/// @throws boost::program_options::error that names the option, where its value is not
void requireGreaterThan0(const std::string& option, double value);

}  // namespace bearing_calibration::core
