#include "../../hier/base/error.hpp"
#include "../../hier/base/files.hpp"

#include "../kit/scratch_dir.hpp"

#include <doctest/doctest.h>
#include <sys/wait.h>
#include <unistd.h>

using namespace tetrakis;

TEST_SUITE_BEGIN("hier");

TEST_CASE("[bad-input] write protection of a file or its directory is respected") {
    const ScratchDir dir;
    write_file(dir / "kept.txt", "one");
    namespace fs = std::filesystem;
    fs::permissions(dir / "kept.txt", fs::perms(0444));
    fs::create_directory(dir / "locked");
    fs::permissions(dir / "locked", fs::perms(0555));
    fs::create_directory(dir / "open");
    fs::permissions(dir / "open", fs::perms(0777));
    fs::permissions(dir.path(), fs::perms(0755));
    // Permissions do not stop root, so it becomes somebody else for this.
    const auto attempts = [&] {
        const auto says = [](const fs::path& path, const char* text) {
            try {
                write_file(path, "two");
            } catch (const Error& error) {
                return error.code() == ErrorCode::io && std::string(error.what()).find(text) != std::string::npos;
            }
            return false;
        };
        const bool file = says(dir / "kept.txt", "write-protected");
        const bool directory = says(dir / "locked/new.txt", "Permission denied");
        write_file(dir / "open/new.txt", "two");
        return (file ? 1 : 0) + (directory ? 2 : 0);
    };
    int result = 0;
    if (::geteuid() != 0) {
        result = attempts();
    } else {
        constexpr uid_t k_nobody = 65534;
        const pid_t child = ::fork();
        REQUIRE(child >= 0);
        if (child == 0) {
            int exit_code = 64;
            try {
                if (::setresuid(k_nobody, k_nobody, k_nobody) == 0) exit_code = attempts();
            } catch (...) {
            }
            ::_exit(exit_code);
        }
        int status = 0;
        REQUIRE(::waitpid(child, &status, 0) == child);
        REQUIRE(WIFEXITED(status));
        result = WEXITSTATUS(status);
    }
    CHECK(result == 3);
    CHECK(slurp(dir / "kept.txt") == "one");
    CHECK(slurp(dir / "open/new.txt") == "two");
}

TEST_CASE("whether a file could be written is found out without a trace") {
    const ScratchDir dir;
    CHECK_THROWS_AS(check_writable(dir / "no/such/place.obj"), Error);
    check_writable(dir / "fine.obj");
    CHECK(dir.file_count() == 0);
}

TEST_CASE("a set of files appears together or not at all") {
    const ScratchDir dir;
    write_file(dir / "b.txt", "old");
    {
        FileSet files;
        files.add(dir / "a.txt").write("a");
        files.add(dir / "b.txt").write("new");
        files.finish();
        CHECK(!std::filesystem::exists(dir / "a.txt"));
        CHECK(slurp(dir / "b.txt") == "old");
        files.add(dir / "c.txt").write("c");
        files.commit();
        CHECK(slurp(dir / "a.txt") == "a");
        CHECK(slurp(dir / "b.txt") == "new");
        CHECK(slurp(dir / "c.txt") == "c");
        CHECK(dir.file_count() == 3);
    }
    {
        FileSet abandoned;
        abandoned.add(dir / "a.txt").write("other");
        abandoned.add(dir / "d.txt").write("other");
        CHECK_THROWS_AS(abandoned.add(dir / "none" / "e.txt"), Error);
        CHECK_THROWS_AS(abandoned.add(dir / "none" / ".." / "a.txt"), Error);
    }
    CHECK(slurp(dir / "a.txt") == "a");
    CHECK(dir.file_count() == 3);
}

TEST_CASE("links stay links, and a replaced file keeps its mode") {
    const ScratchDir dir;
    write_file(dir / "real.txt", "one");
    std::filesystem::permissions(dir / "real.txt", std::filesystem::perms(0600));
    std::filesystem::create_symlink("real.txt", dir / "link.txt");
    write_file(dir / "link.txt", "two");
    CHECK(std::filesystem::is_symlink(dir / "link.txt"));
    CHECK(slurp(dir / "real.txt") == "two");
    CHECK((std::filesystem::status(dir / "real.txt").permissions() & std::filesystem::perms(0777)) ==
          std::filesystem::perms(0600));
    {
        AtomicFile abandoned(dir / "real.txt");
        abandoned.write("three");
    }
    CHECK(slurp(dir / "real.txt") == "two");
    CHECK(dir.file_count() == 2);
}

TEST_SUITE_END();
