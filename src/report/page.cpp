#include "src/report/page.hpp"

#include "pled_vins/core/check.hpp"

namespace pled::report {
namespace {

/// JSON inside a script element: no `<` may end the element or begin a comment.
std::string script_safe(const Json& data) {
  std::string out;
  for (const char c : data.dump(-1, ' ', false, Json::error_handler_t::replace)) {
    if (c == '<')
      out += "\\u003c";
    else
      out += c;
  }
  return out;
}

void put(std::string& page, std::string_view mark, std::string_view text) {
  const std::size_t at = page.find(mark);
  PLED_CHECK(at != std::string::npos);
  page.replace(at, mark.size(), text);
}

}  // namespace

std::string make_page(const Json& data) {
  std::string page(embedded::page_html());
  // In the order of the page: what was put in is never searched for the next mark.
  put(page, "/*STYLE*/", embedded::style_css());
  const std::size_t tail = page.find("<!--DATA-->");
  PLED_CHECK(tail != std::string::npos);
  std::string end = page.substr(tail);
  page.resize(tail);
  put(end, "/*SCRIPTS*/", embedded::scripts_js());
  put(end, "<!--DATA-->",
      "<script id=\"data\" type=\"application/json\">" + script_safe(data) + "</script>");
  return page + end;
}

}  // namespace pled::report
