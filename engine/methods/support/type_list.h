#pragma once

namespace stiefel {

template <class... T>
struct TypeList {};

/// Calls visit(static_cast<T*>(nullptr)) for every T in the list.
template <class... T, class Visit>
void for_each_type(TypeList<T...>, Visit&& visit) {
  (visit(static_cast<T*>(nullptr)), ...);
}

}  // namespace stiefel
