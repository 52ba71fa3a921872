# Installs the build tree BUILD_DIR below WORK_DIR, then configures (with the build tree on PATH, too), builds and runs
# the consumer against it.
#   cmake -DBUILD_DIR=... -DWORK_DIR=... -DGENERATOR=... -DCOMPILER=... [-DLAUNCHER=...] -P run.cmake
file(REMOVE_RECURSE ${WORK_DIR})
function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()
run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${WORK_DIR}/prefix)
set(configure ${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -G ${GENERATOR} -DCMAKE_BUILD_TYPE=Release
    -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER})
# find_package() looks beside the folders of PATH: the program's in the build tree must not be taken for a package.
run(${CMAKE_COMMAND} -E env "PATH=${BUILD_DIR}:${WORK_DIR}/prefix/bin:$ENV{PATH}" ${configure} -B ${WORK_DIR}/by_path)
run(${configure} -B ${WORK_DIR}/build -DCMAKE_PREFIX_PATH=${WORK_DIR}/prefix)
run(${CMAKE_COMMAND} --build ${WORK_DIR}/build)
run(${WORK_DIR}/build/consumer)
