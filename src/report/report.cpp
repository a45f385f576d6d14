#include "pled_vins/report/report.hpp"

#include <cerrno>
#include <cstring>
#include <exception>
#include <fstream>
#include <system_error>
#include <utility>

#include "src/report/page.hpp"
#include "src/report/run_data.hpp"

namespace pled::report {
namespace {

namespace fs = std::filesystem;

/// Of the page; the rest is for paths, counts, features and the page itself.
constexpr std::size_t kPictureBytes = 1'500'000;

/// Whole or not at all. Empty when it was written.
std::string write_file(const fs::path& target, const std::string& text) {
  const fs::path part = target.string() + ".part";
  std::error_code error;
  errno = 0;
  {
    std::ofstream stream(part, std::ios::binary);
    stream << text;
    stream.close();
    if (!stream) {
      const std::string why = std::strerror(errno != 0 ? errno : EIO);
      fs::remove(part, error);
      return "cannot write " + target.string() + ": " + why;
    }
  }
  fs::rename(part, target, error);
  return error ? "cannot write " + target.string() + ": " + error.message() : std::string{};
}

void make_and_write(const std::vector<fs::path>& folders, const std::string& recording,
                    Outcome& outcome) {
  Json data = {{"runs", Json::array()}};
  for (const fs::path& folder : folders) {
    RunData run = load_run(folder, recording, kPictureBytes / folders.size());
    if (!run.error.empty()) {
      outcome.error = run.error;
      return;
    }
    for (std::string& note : run.notes) outcome.notes.push_back(std::move(note));
    data["runs"].push_back(std::move(run.data));
  }
  const std::string page = make_page(data);
  outcome.bytes = page.size();
  outcome.error = write_file(outcome.file, page);
  if (outcome.bytes > kMaxPageBytes)
    outcome.notes.push_back("the page has " + std::to_string(page.size()) +
                            " bytes, more than the " + std::to_string(kMaxPageBytes) + " meant");
}

Outcome write_page(const std::vector<fs::path>& folders, const std::string& recording,
                   const fs::path& target) {
  Outcome outcome;
  outcome.file = target;
  try {
    make_and_write(folders, recording, outcome);
  } catch (const std::exception& error) {  // report.json of another kind, or no memory left
    outcome.error = target.string() + " was not made: " + error.what();
  }
  return outcome;
}

}  // namespace

Outcome write_report(const fs::path& folder, const Options& options) {
  return write_page({folder}, options.recording,
                    options.out.empty() ? folder / kReportFileName : fs::path(options.out));
}

Outcome write_comparison(const fs::path& a, const fs::path& b, const Options& options) {
  return write_page({a, b}, options.recording,
                    options.out.empty() ? b / kComparisonFileName : fs::path(options.out));
}

}  // namespace pled::report
