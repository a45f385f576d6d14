#pragma once

namespace pled::apps {

/// "0.1.0 (443d535)": the release, and the commit it was configured from.
/// "-dirty" when the checkout had changes; the release alone outside a checkout.
[[nodiscard]] const char* version() noexcept;

}  // namespace pled::apps
