#include "src/report/page.hpp"

#include <string>

#include <doctest/doctest.h>

namespace {

using namespace pled::report;

/// What stands between two marks of the page.
std::string between(const std::string& page, const std::string& begin, const std::string& end) {
  const std::size_t from = page.find(begin);
  REQUIRE(from != std::string::npos);
  const std::size_t to = page.find(end, from + begin.size());
  REQUIRE(to != std::string::npos);
  return page.substr(from + begin.size(), to - from - begin.size());
}

TEST_SUITE("report.page") {
  TEST_CASE("data come back as they went in, whatever they hold") {
    Json run;
    run["name"] = "</script><!--<b> /*SCRIPTS*/ /*STYLE*/ <!--DATA-->";
    run["bytes"] = "\xff";
    Json data;
    data["runs"].push_back(run);
    const std::string page = make_page(data);
    const std::string text =
        between(page, "<script id=\"data\" type=\"application/json\">", "</script>");
    const Json back = Json::parse(text);
    CHECK(back["runs"][0]["name"] == run["name"]);
    CHECK(back["runs"][0]["bytes"] == "\xef\xbf\xbd");  // no UTF-8: the replacement character
  }

  TEST_CASE("the page brings everything with it") {
    const std::string page = make_page({{"runs", Json::array()}});
    CHECK(page.find("http:") == std::string::npos);
    CHECK(page.find("https:") == std::string::npos);
    CHECK(page.find(" src=") == std::string::npos);
    CHECK(page.find("@import") == std::string::npos);
    CHECK(page.find("url(") == std::string::npos);
    CHECK(between(page, "href=\"", "\"") == "data:,");
    CHECK(page.find("href=", page.find("href=") + 1) == std::string::npos);
    CHECK(page.find("default-src 'none'") != std::string::npos);
    CHECK(page.find("width=device-width") != std::string::npos);
    CHECK(page.find("/*STYLE*/") == std::string::npos);
    CHECK(page.find("/*SCRIPTS*/") == std::string::npos);
    CHECK(page.size() < 100'000);
  }
}

}  // namespace
