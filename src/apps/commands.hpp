#pragma once

#include <memory>

#include "src/apps/command.hpp"

/// The constructors that command_table.cpp lists; one file each.
namespace pled::apps {

[[nodiscard]] std::unique_ptr<Command> make_ablate_command();
[[nodiscard]] std::unique_ptr<Command> make_check_consistency_command();
[[nodiscard]] std::unique_ptr<Command> make_check_imu_command();
[[nodiscard]] std::unique_ptr<Command> make_compare_command();
[[nodiscard]] std::unique_ptr<Command> make_config_command();
[[nodiscard]] std::unique_ptr<Command> make_evaluate_command();
[[nodiscard]] std::unique_ptr<Command> make_info_command();
[[nodiscard]] std::unique_ptr<Command> make_budget_command();
[[nodiscard]] std::unique_ptr<Command> make_replay_command();
[[nodiscard]] std::unique_ptr<Command> make_score_command();
[[nodiscard]] std::unique_ptr<Command> make_report_command();
[[nodiscard]] std::unique_ptr<Command> make_simulate_command();

}  // namespace pled::apps
