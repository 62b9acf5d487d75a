// Faults of a file are reported with their paths and the name that was meant.
#include "client/cli/message_file.h"

#include <gtest/gtest.h>

#include <cmath>

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
  EXPECT_EQ(fault<v1::Scene>(R"({"initial": {"M": [[0, -1], [1, 0]]}})"),
            "f: initial.M: must be an object with the fields rows, cols, values, imaginary");
  EXPECT_EQ(fault<v1::Scene>(R"({"body": [1, 2, 3]})"),
            "f: body: must be an object with the fields inertia_tensor, moments, attitude, "
            "angular_velocity");
  EXPECT_TRUE(fault<v1::DiagnoseRequest>(R"({"forms": [[1]]})")
                  .starts_with("f: forms[0]: must be an object with the fields form, "));
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

TEST(MessageFile, LeavesWrongTypesToProtobuf) {
  for (const char* text :
       {R"([1])", R"({"step": [1]})", R"({"body": [{"x": 1}]})", R"({"initial": 1})",
        R"({"inertia": {"x": 1}})", R"({"step": {"x": 1}})"}) {
    const std::string told = fault<v1::Scene>(text);
    EXPECT_NE(told, "none") << text;
    EXPECT_EQ(told.find("unknown field"), std::string::npos) << told;
  }
}

}  // namespace
}  // namespace stiefel::cli
