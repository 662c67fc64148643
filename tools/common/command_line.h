#pragma once

#include <boost/program_options.hpp>
#include <cstdlib>
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

/// The same of a program without a status of its own.
/// @param parse  stores the arguments; false when only help was asked for
/// @param work  what is done with them
template <class Arguments>
int runProgram(const char* name, int argc, char** argv, bool (*parse)(int, char**, Arguments*),
               void (*work)(const Arguments&)) {
  return runProgram(name, [&] {
    Arguments arguments;
    if (parse(argc, argv, &arguments)) work(arguments);
    return EXIT_SUCCESS;
  });
}

/// The arguments by their names, stored where the options say. None when only help was asked for,
/// which is printed then.
/// @param visible  options, as --help shows them
/// @param hidden  what `positions` names; its descriptions are said of what is missing
/// @throws boost::program_options::error
std::optional<boost::program_options::variables_map> parseArguments(
    int argc, char** argv, const boost::program_options::options_description& visible,
    const boost::program_options::options_description& hidden = {},
    const boost::program_options::positional_options_description& positions = {});

/// @param option  its name without the dashes
/// @throws boost::program_options::error that names the option, where its value is not
void requireGreaterThan0(const std::string& option, double value);

}  // namespace bearing_calibration::core
