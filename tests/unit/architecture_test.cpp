// Reads every #include of the product and compares it with the two lists below: which folder may
// include which, and which folder may include which third-party header.

#include <algorithm>
#include <array>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <doctest/doctest.h>

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kEverything = "*";
constexpr std::size_t kMaxLines = 400;

/// A folder and the folders it may include; each stands below those it may include.
/// include/pled_vins/x and src/x are one folder x.
struct FolderRule {
  std::string_view folder;
  std::string_view may_include;  ///< names separated by spaces
};

constexpr std::array kFolderRules{
    FolderRule{"core", ""},
    FolderRule{"hal", "core"},
    FolderRule{"geometry", "core"},
    FolderRule{"imu", "core geometry"},
    FolderRule{"events", "core geometry"},
    FolderRule{"reliability", "core geometry"},
    FolderRule{"frontend", "core geometry reliability"},
    FolderRule{"backend", "core geometry imu reliability"},
    FolderRule{"backend/solver", "core geometry imu reliability backend"},
    FolderRule{"drivers/decode", "core hal"},
    FolderRule{"drivers/*", "core hal drivers/decode"},
    FolderRule{"firmware_bridge", "core hal"},
    FolderRule{"pipeline", "core hal geometry imu events reliability frontend backend"},
    FolderRule{"config", "core geometry imu events reliability frontend backend pipeline"},
    FolderRule{"evaluation", "core geometry"},
    FolderRule{"report", "core hal geometry evaluation drivers/decode drivers/replay"},
    FolderRule{"sim", "core hal geometry imu"},
    FolderRule{"apps", kEverything},
};

/// A third-party header, by the start of its name, and the only folders of src/ and drivers/ that
/// may include it. Those with in_headers may also appear under include/.
struct LibraryRule {
  std::string_view header;
  std::string_view folders;
  bool in_headers;
};

constexpr std::string_view kEigenFolders =
    "geometry imu events reliability frontend backend backend/solver pipeline config evaluation "
    "report sim apps";
/// What the operating system offers is no business of the estimator.
constexpr std::string_view kSystemFolders = "drivers/* firmware_bridge pipeline sim apps";

constexpr std::array kLibraryRules{
    LibraryRule{"Eigen/", kEigenFolders, true},
    LibraryRule{"unsupported/Eigen/", kEigenFolders, true},
    LibraryRule{"opencv2/", "frontend sim", false},
    LibraryRule{"ceres/", "backend/solver", false},
    LibraryRule{"libusb", "drivers/usb", false},
    LibraryRule{"png.h", "drivers/replay sim report", false},
    LibraryRule{"jpeglib.h", "drivers/replay sim", false},
    LibraryRule{"lz4frame.h", "drivers/replay", false},
    LibraryRule{"zstd", "drivers/replay", false},
    LibraryRule{"yaml-cpp/", "config", false},
    LibraryRule{"CLI/", "apps", false},
    LibraryRule{"nlohmann/", "report apps", false},
    LibraryRule{"sys/", kSystemFolders, false},
    LibraryRule{"linux/", kSystemFolders, false},
    LibraryRule{"fcntl.h", kSystemFolders, false},
    LibraryRule{"poll.h", kSystemFolders, false},
    LibraryRule{"pthread.h", kSystemFolders, false},
    LibraryRule{"sched.h", kSystemFolders, false},
    LibraryRule{"termios.h", kSystemFolders, false},
    LibraryRule{"unistd.h", kSystemFolders, false},
};

struct Include {
  std::string file;  ///< that includes, relative to the source tree
  std::string target;
  bool angled = false;
};

bool matches(std::string_view folder, std::string_view pattern) {
  if (pattern == kEverything || folder == pattern) return true;
  if (!pattern.ends_with("/*")) return false;
  return folder.starts_with(pattern.substr(0, pattern.size() - 1));
}

bool listed(std::string_view folder, std::string_view list) {
  while (!list.empty()) {
    const std::size_t end = std::min(list.find(' '), list.size());
    if (matches(folder, list.substr(0, end))) return true;
    list.remove_prefix(std::min(end + 1, list.size()));
  }
  return false;
}

/// "core" for include/pled_vins/core/x.hpp and src/core/y.cpp, "drivers/usb" for drivers/usb/z.cpp.
/// Nothing for a path outside the product.
std::optional<std::string> folder_of(std::string_view path) {
  const auto first_part = [](std::string_view rest) -> std::optional<std::string> {
    const std::size_t slash = rest.find('/');
    if (slash == std::string_view::npos) return std::nullopt;
    return std::string{rest.substr(0, slash)};
  };
  if (path.starts_with("firmware_bridge/")) return "firmware_bridge";
  if (path.starts_with("drivers/")) {
    const auto part = first_part(path.substr(std::string_view{"drivers/"}.size()));
    if (!part) return std::nullopt;
    return "drivers/" + *part;
  }
  for (const std::string_view root : {"include/pled_vins/", "src/"}) {
    if (!path.starts_with(root)) continue;
    const std::string_view rest = path.substr(root.size());
    if (rest.starts_with("backend/solver/")) return "backend/solver";
    return first_part(rest);
  }
  return std::nullopt;
}

/// The path in the source tree that a quoted include means, as the compiler looks it up: beside
/// the file, then under include/, then under the root. Empty when there is no such file.
std::string resolve(const fs::path& root, const Include& include) {
  const fs::path beside = fs::path{include.file}.parent_path() / include.target;
  for (const fs::path& candidate :
       {beside, fs::path{"include"} / include.target, fs::path{include.target}}) {
    const fs::path normal = candidate.lexically_normal();
    if (fs::is_regular_file(root / normal)) return normal.generic_string();
  }
  return {};
}

std::string complaint_about_folder(std::string_view from, std::string_view to) {
  if (from == to) return {};
  const auto rule = std::find_if(kFolderRules.begin(), kFolderRules.end(),
                                 [&](const FolderRule& r) { return matches(from, r.folder); });
  if (rule == kFolderRules.end()) return "the folder is not in the dependency list";
  if (listed(to, rule->may_include)) return {};
  return std::string{from} + " may not include " + std::string{to};
}

std::string complaint_about_library(std::string_view from, bool public_header,
                                    std::string_view header) {
  // The C++ standard library has neither a dot nor a slash in its names.
  if (header.find_first_of("./") == std::string_view::npos) return {};
  const auto rule =
      std::find_if(kLibraryRules.begin(), kLibraryRules.end(),
                   [&](const LibraryRule& r) { return header.starts_with(r.header); });
  if (rule == kLibraryRules.end()) return "the header is not in the list of libraries";
  if (public_header && !rule->in_headers) return "a public header may not include this library";
  if (!listed(from, rule->folders)) return std::string{from} + " may not include this library";
  return {};
}

/// What is wrong with an include, or nothing. `target_path` is what a quoted one resolves to.
std::string complaint(const Include& include, std::string_view target_path) {
  const std::optional<std::string> from = folder_of(include.file);
  if (!from) return "the including file is in no folder of the list";
  if (include.angled) {
    const bool public_header = include.file.starts_with("include/");
    return complaint_about_library(*from, public_header, include.target);
  }
  if (target_path.empty()) return "there is no such file";
  const std::optional<std::string> to = folder_of(target_path);
  if (!to) return "the included file is outside the product";
  if (!target_path.starts_with("include/") && include.file.starts_with("include/"))
    return "a public header may not include a private one";
  return complaint_about_folder(*from, *to);
}

/// The include on one line of code, if there is one. An include by macro keeps the macro's name.
std::optional<Include> parse_include(std::string_view line) {
  const auto skip_blanks = [&] {
    line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
  };
  skip_blanks();
  if (!line.starts_with('#')) return std::nullopt;
  line.remove_prefix(1);
  skip_blanks();
  constexpr std::string_view kWord = "include";
  if (!line.starts_with(kWord)) return std::nullopt;
  line.remove_prefix(kWord.size());
  skip_blanks();
  const bool angled = line.starts_with('<');
  if (!angled && !line.starts_with('"')) return Include{{}, std::string{line}, false};
  line.remove_prefix(1);
  return Include{{}, std::string{line.substr(0, line.find(angled ? '>' : '"'))}, angled};
}

/// Files below the given folders whose names end in one of `endings`, relative to the root, sorted.
std::vector<std::string> files_below(const fs::path& root,
                                     std::span<const std::string_view> folders,
                                     std::span<const std::string_view> endings) {
  std::vector<std::string> files;
  for (const std::string_view folder : folders) {
    if (!fs::is_directory(root / folder)) continue;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / folder)) {
      const std::string name = entry.path().filename().string();
      const bool wanted = std::any_of(endings.begin(), endings.end(),
                                      [&](std::string_view e) { return name.ends_with(e); });
      if (wanted && entry.is_regular_file())
        files.push_back(entry.path().lexically_relative(root).generic_string());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

constexpr std::array<std::string_view, 4> kProduct{"include", "src", "drivers", "firmware_bridge"};
constexpr std::array<std::string_view, 7> kSource{
    "include", "src", "drivers", "firmware_bridge", "tests", "scripts", "toolchains"};
constexpr std::array<std::string_view, 5> kCode{".hpp", ".cpp", ".h", ".c", ".inl"};
constexpr std::array<std::string_view, 11> kText{
    ".hpp", ".cpp", ".h", ".c", ".inl", ".sh", ".cmake", "CMakeLists.txt", ".html", ".css", ".js"};

std::vector<std::string> complaints_about_tree(const fs::path& root, std::size_t& includes_read) {
  std::vector<std::string> complaints;
  for (const std::string& file : files_below(root, kProduct, kCode)) {
    std::ifstream in{root / file};
    std::string line;
    for (std::size_t number = 1; std::getline(in, line); ++number) {
      std::optional<Include> include = parse_include(line);
      if (!include) continue;
      ++includes_read;
      include->file = file;
      const std::string what = complaint(*include, resolve(root, *include));
      if (what.empty()) continue;
      complaints.push_back(file + ":" + std::to_string(number) + ": " + include->target + ": " +
                           what);
    }
  }
  return complaints;
}

}  // namespace

TEST_SUITE("architecture") {
  TEST_CASE("every include follows the dependency list") {
    std::size_t includes_read = 0;
    for (const std::string& what : complaints_about_tree(PLED_SOURCE_DIR, includes_read)) {
      FAIL_CHECK(what);
    }
    CHECK(includes_read > 50);  // the tree was found and read
  }

  TEST_CASE("the dependency list only points down") {
    for (std::size_t i = 0; i < kFolderRules.size(); ++i) {
      if (kFolderRules[i].may_include == kEverything) continue;
      for (std::size_t k = i; k < kFolderRules.size(); ++k) {
        CAPTURE(kFolderRules[i].folder);
        CAPTURE(kFolderRules[k].folder);
        CHECK_FALSE(listed(kFolderRules[k].folder, kFolderRules[i].may_include));
      }
    }
  }

  TEST_CASE("no file is longer than its limit") {
    const fs::path root = PLED_SOURCE_DIR;
    for (const std::string& file : files_below(root, kSource, kText)) {
      std::ifstream in{root / file};
      std::size_t lines = 0;
      for (std::string line; std::getline(in, line);) ++lines;
      CAPTURE(file);
      CHECK(lines <= kMaxLines);
    }
  }

  TEST_CASE("a made-up forbidden edge between folders is caught") {
    const auto edge = [](std::string_view file, std::string_view target_path) {
      return complaint({std::string{file}, "x.hpp", false}, target_path);
    };
    CHECK(edge("src/frontend/a.cpp", "include/pled_vins/frontend/x.hpp").empty());
    CHECK(edge("src/frontend/a.cpp", "include/pled_vins/geometry/x.hpp").empty());
    CHECK_FALSE(edge("src/frontend/a.cpp", "include/pled_vins/imu/x.hpp").empty());
    CHECK_FALSE(edge("include/pled_vins/core/a.hpp", "include/pled_vins/geometry/x.hpp").empty());
    CHECK_FALSE(edge("src/backend/a.cpp", "src/backend/solver/x.hpp").empty());
    CHECK(edge("src/backend/solver/a.cpp", "include/pled_vins/backend/x.hpp").empty());
    CHECK(edge("drivers/replay/a.cpp", "drivers/decode/x.hpp").empty());
    CHECK_FALSE(edge("drivers/replay/a.cpp", "drivers/usb/x.hpp").empty());
    CHECK_FALSE(edge("drivers/decode/a.cpp", "drivers/replay/x.hpp").empty());
    CHECK_FALSE(edge("drivers/usb/a.cpp", "include/pled_vins/backend/x.hpp").empty());
    CHECK_FALSE(edge("src/newcomer/a.cpp", "include/pled_vins/core/x.hpp").empty());
    CHECK_FALSE(edge("src/apps/a.cpp", "tests/support/x.hpp").empty());
    CHECK_FALSE(edge("src/apps/a.cpp", "").empty());
    CHECK_FALSE(edge("include/pled_vins/config/a.hpp", "src/config/x.hpp").empty());
  }

  TEST_CASE("a made-up forbidden library is caught") {
    const auto use = [](std::string_view file, std::string_view header) {
      return complaint({std::string{file}, std::string{header}, true}, "");
    };
    CHECK(use("src/core/a.cpp", "vector").empty());
    CHECK(use("src/frontend/a.cpp", "opencv2/core.hpp").empty());
    CHECK_FALSE(use("src/geometry/a.cpp", "opencv2/core.hpp").empty());
    CHECK_FALSE(use("include/pled_vins/frontend/a.hpp", "opencv2/core.hpp").empty());
    CHECK(use("src/backend/solver/a.cpp", "ceres/problem.h").empty());
    CHECK_FALSE(use("src/backend/a.cpp", "ceres/problem.h").empty());
    CHECK_FALSE(use("include/pled_vins/core/a.hpp", "Eigen/Core").empty());
    CHECK_FALSE(use("src/sim/a.cpp", "nlohmann/json.hpp").empty());
    CHECK_FALSE(use("src/backend/a.cpp", "unistd.h").empty());
    CHECK_FALSE(use("src/apps/a.cpp", "boost/optional.hpp").empty());
  }

  TEST_CASE("an include is read from its line however it is spaced") {
    const std::optional<Include> quoted = parse_include(R"(  #  include   "core/x.hpp"  // why)");
    REQUIRE(quoted.has_value());
    CHECK(quoted->target == "core/x.hpp");
    CHECK_FALSE(quoted->angled);
    const std::optional<Include> angled = parse_include("#include<vector>");
    REQUIRE(angled.has_value());
    CHECK(angled->target == "vector");
    CHECK(angled->angled);
    CHECK_FALSE(parse_include("// #include <vector>").has_value());
    CHECK_FALSE(parse_include("#define INCLUDE").has_value());
    const std::optional<Include> by_macro = parse_include("#include HEADER");
    REQUIRE(by_macro.has_value());
    CHECK_FALSE(complaint({"src/apps/a.cpp", by_macro->target, false}, "").empty());
  }
}
