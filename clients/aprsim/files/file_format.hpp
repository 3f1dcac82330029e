#pragma once

#include <string>

#include "clients/aprsim/files/scene_files.hpp"

namespace aprsim::client {

/// The file's text in the common form: keys in the order of docs/site/scene_keys.txt's readers,
/// two spaces for each level, lists and maps in braces with one space after commas and at most 100
/// columns, a single empty line at most. Comments stay with the line below them, or on their line;
/// a comment at the beginning that an empty line ends stays there. Formatting it again changes
/// nothing. Errors: text that is not YAML, or has a form that cannot be kept, such as a block of
/// literal text or a comment within braces.
[[nodiscard]] Outcome<std::string> format_file(const FoundFile& file);

}  // namespace aprsim::client
