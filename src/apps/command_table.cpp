#include "src/apps/commands.hpp"

namespace pled::apps {

std::vector<std::unique_ptr<Command>> all_commands() {
  std::vector<std::unique_ptr<Command>> commands;
  commands.push_back(make_replay_command());
  commands.push_back(make_evaluate_command());
  commands.push_back(make_score_command());
  commands.push_back(make_ablate_command());
  commands.push_back(make_report_command());
  commands.push_back(make_compare_command());
  commands.push_back(make_info_command());
  commands.push_back(make_budget_command());
  commands.push_back(make_config_command());
  commands.push_back(make_check_imu_command());
  commands.push_back(make_check_consistency_command());
  commands.push_back(make_simulate_command());
  return commands;
}

}  // namespace pled::apps
