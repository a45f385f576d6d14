#include "src/apps/command_line.hpp"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>

#include <CLI/CLI.hpp>

#include "pled_vins/config/nearest.hpp"
#include "src/apps/text.hpp"
#include "src/apps/version.hpp"

namespace pled::apps {
namespace {

constexpr const char* kAbout =
    "pled-vins: where a robot is, from an event camera, a frame camera and an IMU.\n"
    "Results go to stdout, words about them to stderr.\n"
    "Exit codes: 0 done, 1 failed, 2 misused.";

/// The subcommands, each declared on the parser.
struct Parser {
  Parser() : app(kAbout, "pled-vins"), commands(all_commands()) {
    app.set_version_flag("--version", std::string("pled-vins ") + version());
    app.require_subcommand(1);
    app.fallthrough();
    for (const auto& command : commands) {
      CLI::App* sub =
          app.add_subcommand(std::string(command->name()), std::string(command->summary()));
      sub->fallthrough();
      sub->footer("Examples:\n" + std::string(command->examples()));
      command->declare(*sub);
      subs.push_back(sub);
    }
    app.footer("`pled-vins COMMAND --help` explains a command, with examples.");
  }

  [[nodiscard]] bool is_command(const std::string& word) const {
    return std::any_of(commands.begin(), commands.end(),
                       [&](const auto& command) { return command->name() == word; });
  }

  /// True when `word` is an option of some command and the next word is its value.
  [[nodiscard]] bool takes_value(const std::string& word) const {
    return std::any_of(subs.begin(), subs.end(), [&](CLI::App* sub) {
      const CLI::Option* option = sub->get_option_no_throw(word);
      return option != nullptr && option->get_items_expected_min() > 0;
    });
  }

  CLI::App app;
  std::vector<std::unique_ptr<Command>> commands;
  std::vector<CLI::App*> subs;
};

/// Options may stand before the subcommand too: its name is moved to the front.
/// Fills `unknown` with the word that stands where a subcommand should.
std::vector<std::string> command_first(const Parser& parser, std::vector<std::string> words,
                                       std::string& unknown) {
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i].empty() || words[i].front() == '-') {
      if (parser.takes_value(words[i])) ++i;
      continue;
    }
    if (parser.is_command(words[i])) {
      const auto word = words.begin() + static_cast<std::ptrdiff_t>(i);
      std::rotate(words.begin(), word, word + 1);
    } else {
      unknown = words[i];
    }
    return words;
  }
  return words;
}

ExitCode refuse_unknown_command(const Parser& parser, const std::string& word) {
  std::vector<std::string_view> names;
  for (const auto& command : parser.commands) names.push_back(command->name());
  print_error("there is no command '" + word + "': did you mean '" +
              std::string(nearest(word, names)) + "'? `pled-vins --help` lists all.");
  return ExitCode::kMisused;
}

/// Words behind `--` are names even when they begin with a dash. Every such word is a path
/// here: written as one, it needs no `--`.
void spell_out_names(std::vector<std::string>& words) {
  const auto dashes = std::find(words.begin(), words.end(), "--");
  if (dashes == words.end()) return;
  for (auto word = words.erase(dashes); word != words.end(); ++word)
    if (word->starts_with('-')) word->insert(0, "./");
}

/// What CLI11 found wrong, with the option that was likely meant.
ExitCode refuse_misuse(const Parser& parser, const CLI::ParseError& error) {
  std::string text = error.what();
  std::string help = "`pled-vins --help`";
  if (parser.app.get_subcommands().empty()) {
    for (const std::string& word : parser.app.remaining(true))
      text += ". '" + word + "' is unknown without one";
  }
  for (CLI::App* sub : parser.app.get_subcommands()) {
    help = "`pled-vins " + sub->get_name() + " --help`";
    std::vector<std::string> names;
    for (const CLI::Option* option : sub->get_options())
      for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    const std::vector<std::string_view> candidates(names.begin(), names.end());
    for (const std::string& word : parser.app.remaining(true)) {
      const std::string_view meant = nearest(word, candidates);
      if (word.starts_with("-") && word != meant)
        text += ". Instead of '" + word + "', did you mean '" + std::string(meant) + "'?";
    }
  }
  const bool ended = text.ends_with('?') || text.ends_with('.');
  print_error(text + (ended ? " " : ". ") + help + " shows how.");
  return ExitCode::kMisused;
}

ExitCode parse_and_run(int argc, const char* const* argv) {
  Parser parser;
  std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
  if (words.empty()) {
    std::fputs(parser.app.help().c_str(), stderr);
    return ExitCode::kMisused;
  }
  spell_out_names(words);
  std::string unknown;
  words = command_first(parser, std::move(words), unknown);
  if (!unknown.empty()) return refuse_unknown_command(parser, unknown);
  try {
    std::reverse(words.begin(), words.end());  // the order that CLI11 wants
    parser.app.parse(words);
  } catch (const CLI::Success& wish) {  // --help, --version
    return parser.app.exit(wish) == 0 ? ExitCode::kDone : ExitCode::kFailed;
  } catch (const CLI::ParseError& error) {
    return refuse_misuse(parser, error);
  }
  for (const auto& command : parser.commands)
    if (parser.app.got_subcommand(std::string(command->name()))) return command->run();
  return ExitCode::kMisused;
}

}  // namespace

ExitCode run(int argc, const char* const* argv) noexcept {
  ExitCode code = ExitCode::kFailed;
  try {
    code = parse_and_run(argc, argv);
  } catch (const std::exception& error) {
    print_error(error.what());
    code = ExitCode::kFailed;
  }
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
    print_error("the result could not be written to stdout");
    return code == ExitCode::kMisused ? code : ExitCode::kFailed;
  }
  return code;
}

}  // namespace pled::apps
