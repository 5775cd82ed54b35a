#include "apps/common/report_html.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <regex>

#include "apps/common/report_data.h"
#include "apps/common/report_headline.h"
#include "apps/common/report_plots.h"
#include "apps/common/report_tables.h"

namespace accel::apps {
namespace {

using testing::HasSubstr;
using testing::Not;

Json row(const std::string& method, const std::string& kind, double mrays, double wrong) {
  return {
      {"method", method},
      {"rays_kind", kind},
      {"rays", 1000000},
      {"mrays_per_second", mrays},
      {"mrays_min", mrays / 2},
      {"mrays_max", mrays * 2},
      {"ratio_to_embree", mrays / 4},
      {"verdicts", {{"agree", 999000}, {"judged", 1000}, {"right", 1000 - wrong}, {"miss", wrong}, {"far", 0}, {"false", 0}}},
      {"embree_verdicts", {{"miss", 20}, {"far", 0}, {"false", 0}}},
      {"embree_wrong_per_million", 20.0},
      {"embree_wrong_per_million_bound95", 20.0},
      {"wrong_per_million", wrong},
      {"wrong_per_million_bound95", wrong > 0 ? wrong : 3.0}};
}

Json embree_row(const std::string& method, const std::string& kind, double mrays) {
  return {{"method", method},          {"rays_kind", kind},  {"rays", 1000000},
          {"mrays_per_second", mrays}, {"mrays_min", mrays}, {"mrays_max", mrays}};
}

Json run(const std::string& scene = "folder/scene.obj") {
  Json context = {{"date", "2026-01-02T03:04:05+0000"},
                  {"host_name", "host"},
                  {"command_line", "accel-trace " + scene},
                  {"num_cpus", 4},
                  {"library_build_type", "Release"},
                  {"versions", {{"libaccel", "1"}, {"compiler", "c"}}},
                  {"threads", 4},
                  {"seed", 1},
                  {"repeat", 5},
                  {"scene", scene},
                  {"triangles", 1000},
                  {"load_seconds", 0.5},
                  {"camera", {{"name", "c"}, {"eye", {0, 0, 0}}, {"at", {0, 0, 1}}, {"vfov", 45.0}}},
                  {"width", 10},
                  {"height", 10},
                  {"spp", 1},
                  {"pixel_order", "z-curve"},
                  {"device", "cpu"},
                  {"check", "checked"},
                  {"witness", "Embree"},
                  {"notes", Json::array()},
                  {"skipped", Json::array()}};
  context["structures"] = {{{"name", "bvh"}, {"build_seconds", 0.25}, {"bytes", 64000}, {"leaf_sizes", {0, 30, 70}}}};
  return {{"context", context},
          {"benchmarks",
           {row("bvh/slow", "primary", 2, 0), row("bvh/clean", "primary", 5, 0), row("bvh/fast", "primary", 9, 7),
            embree_row("Embree", "primary", 4), embree_row("Embree/robust", "primary", 3)}}};
}

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != text.npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST(Html, NothingIsReadAsMarkup) {
  EXPECT_EQ(html_escaped("<a href=\"x\">&'"), "&lt;a href=&quot;x&quot;&gt;&amp;&#39;");
  EXPECT_EQ(json_in_script("{\"a\": \"</script><!--\"}"), "{\"a\": \"\\u003c/script>\\u003c!--\"}");
}

TEST(Html, Base64) {
  for (const auto& [bytes, text] : {std::pair{"", ""}, {"f", "Zg=="}, {"fo", "Zm8="}, {"foo", "Zm9v"}, {"foobar", "Zm9vYmFy"}})
    EXPECT_EQ(base64(bytes), text);
  EXPECT_EQ(base64("\xff\xfe"), "//4=");
}

TEST(Html, EmptyColumnsAreLeftOut) {
  HtmlTable table("caption", {{"a"}, {"b"}, {"c"}});
  table.add_row({row_head("x"), {"", HtmlCell::Kind::number}, words("<y>")});
  EXPECT_THAT(table.html(), HasSubstr(">a</th>"));
  EXPECT_THAT(table.html(), Not(HasSubstr(">b</th>")));
  EXPECT_THAT(table.html(), HasSubstr("&lt;y&gt;"));
}

TEST(ReportData, NsComeFromTheJsonOrFromTheSpeed) {
  Json json = run();
  json["benchmarks"][0]["ns_per_ray"] = 123.0;
  const ReportData data(json.dump());
  const auto rows = data.rows("primary");
  EXPECT_EQ(rows[0]->ns, 123);
  EXPECT_EQ(rows[1]->ns, 200);
  EXPECT_THAT(data.ns_cell(*rows[1]).attributes, HasSubstr("/benchmarks/1/mrays_per_second"));
}

TEST(ReportData, TheFrontIsFoundOrTaken) {
  Json json = run();
  const ReportData found(json.dump());
  EXPECT_FALSE(found.is_on_front(*found.rows("primary")[0]));  // bvh/clean is faster and as right
  EXPECT_TRUE(found.is_on_front(*found.rows("primary")[1]));
  EXPECT_TRUE(found.is_on_front(*found.rows("primary")[2]));
  EXPECT_FALSE(found.is_on_front(*found.rows("primary")[3]));  // Embree is no method of ours
  json["benchmarks"][0]["pareto"] = true;
  const ReportData taken(json.dump());
  EXPECT_TRUE(taken.is_on_front(*taken.rows("primary")[0]));
}

TEST(ReportData, ZeroesAreShownAsBounds) {
  const ReportData data(run().dump());
  EXPECT_EQ(data.wrong_cell(*data.rows("primary")[1]).text, "< 3.00");
  EXPECT_EQ(data.wrong_cell(*data.rows("primary")[2]).text, "7.00");
  EXPECT_EQ(data.witness_wrong_cell(*data.rows("primary")[1]).text, "20.0");
}

TEST(ReportData, RatesOfNoRaysAreDashes) {
  Json json = run();
  for (const char* key : {"wrong_per_million", "wrong_per_million_bound95", "embree_wrong_per_million"})
    json["benchmarks"][1][key] = nullptr;
  const ReportData data(json.dump());
  EXPECT_EQ(data.wrong_cell(*data.rows("primary")[1]).text, "\u2013");
  EXPECT_EQ(data.witness_wrong_cell(*data.rows("primary")[1]).text, "\u2013");
  EXPECT_FALSE(ReportData::witness_wrong(*data.rows("primary")[1]));
}

TEST(ReportHeadline, TheFastestWithoutAWrongHitIsNamed) {
  const ReportData data(run().dump());
  EXPECT_THAT(finding_html(data), HasSubstr("<b>bvh/clean</b> is the fastest of 2 methods without a wrong hit: 200 ns a ray"));
  EXPECT_THAT(finding_html(data), HasSubstr("20.0 in a million are wrong"));
  EXPECT_THAT(alarm_html(data), HasSubstr("bvh/fast"));
  EXPECT_THAT(alarm_html(data), Not(HasSubstr("bvh/clean")));
}

TEST(ReportHeadline, AllWrongOrUnchecked) {
  Json json = run();
  for (Json& r : json["benchmarks"]) r["wrong_per_million"] = 5.0;
  EXPECT_THAT(finding_html(ReportData(json.dump())), HasSubstr("No method is without wrong hits"));
  for (Json& r : json["benchmarks"]) r.erase("wrong_per_million");
  EXPECT_THAT(finding_html(ReportData(json.dump())), HasSubstr("<b>bvh/fast</b> is the fastest of 3 methods"));
  EXPECT_FALSE(pareto_plot(ReportData(json.dump())));
}

TEST(ReportHeadline, OfASweep) {
  Json json = run();
  json["context"]["advice"] = {{"primary", "use <this>"}, {"edge", "use that"}};
  json["benchmarks"][2]["promised"] = false;
  json["benchmarks"][1]["error"] = {{"per_million", 40.0}, {"bound95_per_million", 40.0}};
  const ReportData data(json.dump());
  EXPECT_THAT(finding_html(data), HasSubstr("Use &lt;this&gt;."));
  EXPECT_THAT(finding_html(data), HasSubstr("Use that."));
  EXPECT_THAT(alarm_html(data), Not(HasSubstr("bvh/fast")));  // there to be compared
  EXPECT_THAT(alarm_html(data), HasSubstr("bvh/clean"));      // of edge rays
  EXPECT_EQ(data.wrong_cell(*data.rows("primary")[1]).text, "40.0");
}

TEST(ReportPlots, MarksAreTheRows) {
  const ReportData data(run().dump());
  const auto plot = pareto_plot(data);
  ASSERT_TRUE(plot);
  const Json& marks = plot->spec["data"]["values"];
  ASSERT_EQ(marks.size(), 5u);
  EXPECT_EQ(marks[1]["ns"], 200);
  EXPECT_EQ(marks[1]["wrong"], 0);
  EXPECT_EQ(marks[1]["bound"], 3);
  EXPECT_TRUE(marks[3]["wrong"].is_null());  // nobody judged it
  EXPECT_EQ(marks[4]["wrong"], 20);          // the witness
  EXPECT_EQ(plot->spec["spec"]["layer"][0]["encoding"]["color"]["scale"]["domain"].size(), 3u);
  EXPECT_EQ(speed_plot(data)->spec["data"]["values"].size(), 5u);
}

TEST(ReportPlots, TestsAreShapes) {
  Json json = run();
  json["benchmarks"][0]["test"] = "watertight", json["benchmarks"][1]["test"] = "moeller-trumbore";
  json["benchmarks"][0]["name"] = "scene/bvh/slow/primary",
  json["benchmarks"][1]["name"] = "scene/bvh/clean/primary/moeller-trumbore";
  const ReportData data(json.dump());
  EXPECT_EQ(data.rows("primary")[1]->label, "bvh/clean + moeller-trumbore");
  const auto plot = pareto_plot(data);
  EXPECT_EQ(plot->spec["spec"]["layer"][0]["encoding"]["shape"]["field"], "test");
}

TEST(ReportPlots, HistogramsAreShares) {
  const auto plot = leaf_sizes_plot(ReportData(run().dump()));
  ASSERT_TRUE(plot);
  EXPECT_EQ(plot->spec["data"]["values"][2]["share"], 0.7);
  EXPECT_FALSE(leaf_depths_plot(ReportData(run().dump())));
}

TEST(ReportTables, MethodsThatAreJudgedAlikeShareARow) {
  Json json = run();
  json["benchmarks"] = Json::array();
  for (const char* method : {"a", "b", "c", "d"}) json["benchmarks"].push_back(row(method, "primary", 1, 0));
  EXPECT_THAT(verdicts_table(ReportData(json.dump())), HasSubstr("all 4 methods"));
  json["benchmarks"].push_back(row("e", "primary", 1, 2));
  EXPECT_THAT(verdicts_table(ReportData(json.dump())), HasSubstr("the other 4 methods"));
  EXPECT_THAT(verdicts_table(ReportData(json.dump())), HasSubstr(">e</th>"));
}

TEST(ReportHtml, CarriesItsJson) {
  const std::string json = run().dump(2);
  const std::string page = report_html(json, {});
  const std::string begin = "id=\"numbers\">";
  const std::size_t from = page.find(begin) + begin.size();
  EXPECT_EQ(Json::parse(page.substr(from, page.find("</script>", from) - from)), Json::parse(json));
}

TEST(ReportHtml, SaysInWhichOrderPixelsCame) {
  Json json = run();
  EXPECT_THAT(report_html(json.dump(), {}), HasSubstr("10 × 10 pixels along a Z-curve, 1 a pixel"));
  json["context"]["pixel_order"] = "rows";
  EXPECT_THAT(report_html(json.dump(), {}), HasSubstr("10 × 10 pixels, 1 a pixel"));
}

TEST(ReportHtml, HostileNamesStayText) {
  const std::string hostile = "\"><script>alert(1)</script><!--{{script}}";
  Json json = run(hostile), tame = run("tame.obj");
  json["benchmarks"][0]["method"] = hostile, json["context"]["skipped"].push_back({{"what", hostile}, {"because", hostile}});
  tame["context"]["skipped"].push_back({{"what", "a"}, {"because", "b"}});
  const std::string page = report_html(json.dump(), {}), tame_page = report_html(tame.dump(), {});
  EXPECT_THAT(page, Not(HasSubstr("<script>alert")));
  for (const char* part : {"<script", "</script", "<!--"}) EXPECT_EQ(count_of(page, part), count_of(tame_page, part)) << part;
  EXPECT_THAT(page, HasSubstr("&lt;script&gt;alert(1)&lt;/script&gt;&lt;!--{{script}}"));
}

TEST(ReportHtml, FetchesNothing) {
  const std::string page = report_html(run().dump(), {});
  EXPECT_THAT(page, HasSubstr("default-src 'none'"));
  EXPECT_FALSE(std::regex_search(page.substr(0, page.find("id=\"numbers\"")), std::regex(R"((src|href)="(?!data:))")));
}

TEST(ReportHtml, OfARunWithoutRows) {
  Json json = run();
  json["benchmarks"] = Json::array(), json["context"]["structures"] = Json::array();
  EXPECT_THAT(report_html(json.dump(), {}), HasSubstr("scene.obj"));
}

}  // namespace
}  // namespace accel::apps
