#pragma once

#include <string>
#include <string_view>

#include "src/report/json.hpp"

namespace pled::report {

/// The page that shows one run or two: {"runs": [...]}.
[[nodiscard]] std::string make_page(const Json& data);

/// The files of src/report/page/, embedded by CMake.
namespace embedded {
[[nodiscard]] std::string_view page_html() noexcept;
[[nodiscard]] std::string_view style_css() noexcept;
/// All scripts, one after the other.
[[nodiscard]] std::string_view scripts_js() noexcept;
}  // namespace embedded

}  // namespace pled::report
