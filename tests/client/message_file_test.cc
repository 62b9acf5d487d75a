// Faults of a file are reported with their paths and the name that was meant.
#include "client/cli/input/message_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>

#include "client/cli/exit_status.h"
#include "stiefel/v1/simulation.pb.h"

namespace stiefel::cli {
namespace {

template <class Message>
std::string fault(const std::string& text) {
  Message message;
  try {
    parse_message("f", text, &message);
    return "none";
  } catch (const BadInput& bad) {
    return bad.what();
  }
}

TEST(MessageFile, NamesAnUnknownFieldByItsPathAndTheNearOne) {
  using S = v1::Scene;
  EXPECT_EQ(fault<S>(R"({"stepp": 1})"), "f: stepp: unknown field; did you mean step?");
  EXPECT_EQ(fault<S>(R"({"body": {"inertia_tensr": []}})"),
            "f: body.inertia_tensr: unknown field; did you mean inertia_tensor?");
  EXPECT_EQ(fault<S>(R"({"initial": {"Q": {"rows": 1, "value": [1]}}})"),
            "f: initial.Q.value: unknown field; did you mean values?");
  EXPECT_EQ(fault<S>(R"({"method": {"nme": "rk4"}})"),
            "f: method.nme: unknown field; did you mean name?");
  EXPECT_EQ(fault<S>(R"({"inertia_tensr": []})"),
            "f: inertia_tensr: unknown field; did you mean body.inertia_tensor?");
  EXPECT_EQ(fault<S>(R"({"mass": 1})"), "f: mass: unknown field");
  EXPECT_EQ(fault<S>(R"({"step": 1, "Step": 2})"), "f: Step: unknown field; did you mean step?");
}

TEST(MessageFile, NamesTheElementOfAList) {
  using R = v1::DiagnoseRequest;
  EXPECT_EQ(fault<R>(R"({"forms": [{"form": "omega"}, {"frist": {}}]})"),
            "f: forms[1].frist: unknown field; did you mean first?");
  EXPECT_EQ(fault<R>(R"({"forms": [{"first": {"Q": {"colls": 3}}}]})"),
            "f: forms[0].first.Q.colls: unknown field; did you mean cols?");
  EXPECT_EQ(fault<R>(R"({"dirac_brackets": [{"first": [{"A": {}}, {"C": {}}]}]})"),
            "f: dirac_brackets[0].first[1].C: unknown field");
}

TEST(MessageFile, RefusesAnArrayInPlaceOfAMessage) {
  EXPECT_EQ(fault<v1::Scene>(R"({"body": [1, 2, 3]})"),
            "f: body: a list: must be an object with the fields inertia_tensor, moments, attitude, "
            "angular_velocity");
  EXPECT_TRUE(fault<v1::DiagnoseRequest>(R"({"forms": [[1]]})")
                  .starts_with("f: forms[0]: a list: must be an object with the fields form, "));
}

TEST(MessageFile, TakesBlocksOfAnyName) {
  EXPECT_EQ(fault<v1::Scene>(R"({"initial": {"anything": {"rows": 1, "cols": 1}}})"), "none");
}

TEST(MessageFile, TakesTheNamesOfProtoAndOfJson) {
  using R = v1::FramePair;
  EXPECT_EQ(fault<R>(R"({"Q_0": {"rows": 1}, "q_t": {"rows": 1}})"), "none");
  EXPECT_EQ(fault<R>(R"({"Q_1": {}})"), "f: Q_1: unknown field; did you mean Q_0?");
  EXPECT_EQ(fault<v1::Scene>(R"({"inertiaU": [1]})"), "none");
}

TEST(MessageFile, NamesWhatIsGivenTwiceByItsPath) {
  EXPECT_EQ(fault<v1::Scene>(R"({"initial": {"Q": {"rows": 1, "rows": 1}}})"),
            "f: initial.Q.rows: given twice");
  EXPECT_EQ(fault<v1::Scene>(R"({"initial": {"Q": {}, "Q": {}}})"), "f: initial.Q: given twice");
}

TEST(MessageFile, AnObjectMayHoldTheFieldsOfTwoMessages) {
  v1::ConnectRequest request;
  v1::FramePair pair;
  parse_messages("f", R"({"inertia": [1, 2], "Q_0": {"rows": 1, "values": [-0.0]}, "time": 0.1})",
                 {&request, &pair});
  EXPECT_EQ(request.inertia_size(), 2);
  EXPECT_EQ(request.time(), 0.1);
  EXPECT_TRUE(std::signbit(pair.q_0().values(0)));
  EXPECT_FALSE(pair.has_q_t());
  try {
    parse_messages("f", R"({"Q_1": {}})", {&request, &pair});
    ADD_FAILURE() << "an unknown field was taken";
  } catch (const BadInput& bad) {
    EXPECT_STREQ(bad.what(), "f: Q_1: unknown field; did you mean Q_0?");
  }
}

TEST(MessageFile, NamesAWrongTypeByItsPathAndSaysWhatItMustBe) {
  using S = v1::Scene;
  for (const auto& [text, told] : std::map<std::string, std::string>{
           {R"([1])", "a list: must be an object: {...}"},
           {R"("scene")", "\"scene\": must be an object: {...}"},
           {R"(3)", "3: must be an object: {...}"},
           {R"(null)", "null: must be an object: {...}"},
           {R"({"step": [1]})", "step: a list: must be a number"},
           {R"({"step": "soon"})", "step: \"soon\": must be a number"},
           {R"({"step": true})", "step: true: must be a number"},
           {R"({"step": {"x": 1}})", "step: an object: must be a number"},
           {R"({"inertia": 3})", "inertia: 3: must be a list: [...]"},
           {R"({"inertia": {"x": 1}})", "inertia: an object: must be a list: [...]"},
           {R"({"inertia": [1, "a"]})", "inertia[1]: \"a\": must be a number"},
           {R"({"inertia": [1, null]})", "inertia[1]: null: must be a number"},
           {R"({"inertia": [[[[1]]]]})", "inertia[0][0][0]: a list: must be a number"},
           {R"({"inertia": [[1, 2], [3]]})", "inertia: must be rows of one length"},
           {R"({"members": 1.5})", "members: 1.5: must be a whole number of at least 0"},
           {R"({"members": -1})", "members: -1: must be a whole number of at least 0"},
           {R"({"members": "x"})", "members: \"x\": must be a whole number of at least 0"},
           {R"({"system": 3})", "system: 3: must be a text"},
           {R"({"initial": 1})", "initial: 1: must be an object of names and values"},
           {R"({"initial": [1]})", "initial: a list: must be an object of names and values"},
           {R"({"initial": {"Q": {"values": [true]}}})",
            "initial.Q.values[0]: true: must be a number"},
       })
    EXPECT_EQ(fault<S>(text), "f: " + told) << text;
  EXPECT_EQ(fault<v1::SummarizeRequest>(R"({"events": [{"terminal": 1}]})"),
            "f: events[0].terminal: 1: must be true or false");
  EXPECT_TRUE(
      fault<v1::ConnectRequest>(R"({"metric": "flat"})")
          .starts_with("f: metric: \"flat\": must be one of METRIC_UNSPECIFIED, METRIC_LAMBDA"));
}

TEST(MessageFile, TakesWhatProtobufTakes) {
  for (const char* text :
       {R"({"step": "NaN"})", R"({"step": "-Infinity"})", R"({"step": "1.5"})", R"({"step": null})",
        R"({"members": 4.0})", R"({"members": "4"})", R"({"initial": null})",
        R"({"inertia": null})", R"({"inertia": ["Infinity", 1]})", R"({"body": null})", R"({})"})
    EXPECT_EQ(fault<v1::Scene>(text), "none") << text;
}

TEST(MessageFile, AMatrixMayBeItsRows) {
  v1::Scene rows, whole;
  parse_message("f", R"({"initial": {"Q": [[1, -0.0, 0.1], [1e-300, 2, 3]], "M": [1, 2]}})", &rows);
  parse_message("f",
                R"({"initial": {"Q": {"rows": 2, "cols": 3, "values": [1, -0.0, 0.1, 1e-300, 2, 3]},
                                "M": {"rows": 1, "cols": 2, "values": [1, 2]}}})",
                &whole);
  for (const char* name : {"Q", "M"})
    EXPECT_EQ(rows.initial().at(name).SerializeAsString(),
              whole.initial().at(name).SerializeAsString());
  v1::ConnectRequest pairs;
  parse_message("f", R"({"pairs": [{"Q_0": [[1, 0]], "Q_T": [[0, 1]]}]})", &pairs);
  EXPECT_EQ(pairs.pairs(0).q_t().values(1), 1);
  using S = v1::Scene;
  EXPECT_EQ(fault<S>(R"({"initial": {"Q": [[1, 2], [3]]}})"),
            "f: initial.Q: must be rows of one length");
  EXPECT_EQ(fault<S>(R"({"initial": {"Q": [1, [3]]}})"),
            "f: initial.Q: must be rows of one length");
  EXPECT_EQ(fault<S>(R"({"initial": {"Q": [[[[1]]]]}})"),
            "f: initial.Q[0][0][0]: a list: must be a number");
  EXPECT_EQ(fault<S>(R"({"initial": {"Q": [["a"]]}})"),
            "f: initial.Q[0][0]: \"a\": must be a number");
  EXPECT_EQ(fault<S>(R"({"initial": {"Q": [{"rows": 1}]}})"),
            "f: initial.Q[0]: an object: must be a row of numbers");
}

TEST(MessageFile, ListsMayHaveAListForEachMember) {
  v1::Scene nested, flat;
  parse_message("f", R"({"inertia": [[1, 2], [3, 4]], "initial": {"Q": [[[1, 2]], [[3, 4]]],
                         "P": {"values": [[1, 2]], "imaginary": [[3, 4]]}}})",
                &nested);
  parse_message("f", R"({"inertia": [1, 2, 3, 4], "initial": {
                         "Q": {"rows": 2, "cols": 2, "values": [1, 2, 3, 4]},
                         "P": {"rows": 1, "cols": 2, "values": [1, 2], "imaginary": [3, 4]}}})",
                &flat);
  EXPECT_EQ(to_json(nested), to_json(flat));
}

TEST(MessageFile, MatricesAreWrittenAsTheirRows) {
  v1::Scene scene;
  parse_message("f", R"({"initial": {"Q": {"rows": 2, "cols": 1, "values": [-0.0, 0.1]},
                         "P": {"rows": 1, "cols": 2, "values": [1, 2], "imaginary": [3, 4]}}})",
                &scene);
  EXPECT_EQ(to_json(scene).dump(),
            R"({"initial":{"P":{"values":[[1,2]],"imaginary":[[3,4]]},"Q":[[-0.0],[0.1]]}})");
  v1::Scene again;
  parse_message("f", to_json(scene).dump(), &again);
  EXPECT_EQ(to_json(again), to_json(scene));
}

TEST(MessageFile, AByteOrderMarkIsNoPartOfTheText) {
  EXPECT_EQ(fault<v1::Scene>("\xef\xbb\xbf{\"step\": 1}"), "none");
  EXPECT_EQ(fault<v1::Scene>(std::string("\xff\xfe{\0}\0", 6)), "f: is UTF-16: must be UTF-8");
}

}  // namespace
}  // namespace stiefel::cli
