#include "stiefel/simulation.h"

namespace stiefel {
namespace {

thread_local Crew* crew_of_this_thread = nullptr;

}  // namespace

CrewOfThisThread::CrewOfThisThread(Crew& crew) { crew_of_this_thread = &crew; }
CrewOfThisThread::~CrewOfThisThread() { crew_of_this_thread = nullptr; }
Crew* CrewOfThisThread::find() { return crew_of_this_thread; }

}  // namespace stiefel
