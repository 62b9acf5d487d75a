# Makes a copy of Eigen 3.4.0 in the build folder that g++ 12 compiles faster. Types, functions and the code that comes out
# of them are those of Eigen as installed (docs/decisions/0009-precompiled-headers.md). The copy serves <Eigen/Dense> alone.
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
get_target_property(installed Eigen3::Eigen INTERFACE_INCLUDE_DIRECTORIES)
if(NOT Eigen3_VERSION VERSION_EQUAL 3.4.0 OR NOT EXISTS ${installed}/Eigen/Dense)
  return()
endif()
set(copy ${PROJECT_BINARY_DIR}/eigen)
include_directories(BEFORE SYSTEM ${copy})
file(SHA256 ${CMAKE_CURRENT_LIST_FILE} made_by)
if(EXISTS ${copy}/made_by)
  file(READ ${copy}/made_by earlier)
  if(earlier STREQUAL made_by)
    return()
  endif()
endif()
file(REMOVE_RECURSE ${copy})
file(COPY ${installed}/Eigen DESTINATION ${copy})
set(src ${copy}/Eigen/src)

# The operators () that take lists of indices, 22 in each class of expressions, are left out. g++ gives their types equal
# hashes, so that the time to compile a file grows with the square of the number of its expressions.
file(WRITE ${src}/plugins/IndexedViewMethods.h "")

# Each class of expressions has names of its own for its numbers, Scalar and RealScalar. For each such name g++ keeps a
# variant of `double`, and looks for `const Scalar` among the variants of all classes. add_const<Scalar>::type is found at once.
foreach(header ArrayBase Block CommaInitializer CoreEvaluators CwiseNullaryOp CwiseUnaryView DenseBase DenseCoeffsBase
               Diagonal DiagonalMatrix Dot Fuzzy MapBase Matrix MatrixBase PlainObjectBase SelfCwiseBinaryOp Transpose
               TriangularMatrix products/GeneralMatrixMatrixTriangular ../Householder/Householder ../LU/InverseImpl
               ../plugins/MatrixCwiseBinaryOps)
  file(READ ${src}/Core/${header}.h text)
  string(REGEX REPLACE "const ((Real|Packet)?Scalar|typename NumTraits<Scalar>::Real)([^A-Za-z0-9_:])"
                       "typename Eigen::internal::add_const<\\1>::type\\3" text "${text}")
  file(WRITE ${src}/Core/${header}.h "${text}")
endforeach()
file(WRITE ${copy}/made_by ${made_by})
