#pragma once

namespace pled {

/// The first broken rule of a settings struct, in the words of the file;
/// key == nullptr when there is none.
struct ConfigIssue {
  const char* key = nullptr;
  const char* rule = nullptr;
};

}  // namespace pled
