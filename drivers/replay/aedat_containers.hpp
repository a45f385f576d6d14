#pragma once

#include <memory>
#include <string>

#include "drivers/replay/aedat2_sources.hpp"
#include "drivers/replay/aedat4_header.hpp"
#include "drivers/replay/container.hpp"

namespace pled::replay {

/// The two kinds of Container; errors as Container::open().
[[nodiscard]] Result<std::shared_ptr<const Container>> open_aedat2(const std::string& path,
                                                                   Problems& problems);
[[nodiscard]] Result<std::shared_ptr<const Container>> open_aedat4(const std::string& path,
                                                                   Problems& problems);

}  // namespace pled::replay
