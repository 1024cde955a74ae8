"""What is left out of exported models: functions that nothing calls, and those alone."""

from __future__ import annotations

from planarc.export.pruned import calls_in, numbers_of, prune, without

TEXT = """
declare void @pc_far()
; One that calls another.
define i32 @one(i64 %a) nounwind {
  call void @two(i64 1)
  ret i32 0
}

; A circle that nothing leads to.
define i32 @three(i64 %a) nounwind {
  call i32 @four(i64 1)
  ret i32 0
}
define void @two(i64 %a) nounwind {
  call void @pc_far()
  ret void
}
define i32 @four(i64 %a) nounwind {
  %v1 = call i32 @three(i64 1)
  ret i32 %v1
}
@table = constant [1 x i64] [i64 1]
"""


def test_functions_stay_that_are_reached() -> None:
    left = prune(TEXT, ["one"])
    assert "@one" in left and "void @two" in left and "One that calls" in left
    assert "@three" not in left and "@four" not in left and "circle" not in left
    assert "declare void @pc_far()" in left and "@table = constant" in left


def test_circles_stay_where_one_of_them_is_wanted() -> None:
    left = prune(TEXT, ["four"])
    assert "@three" in left and "@four" in left and "@two" not in left
    assert prune(TEXT, ["one", "four"]) == TEXT


def test_declarations_are_no_calls() -> None:
    assert calls_in("declare void @far()\n" + TEXT) == {"one", "two", "three", "four", "pc_far"}


LOADED = """
define i64 @one(i64 %a) nounwind {
  %v1 = getelementptr inbounds i64, ptr @px_plan, i64 1
  %v2 = load i64, ptr %v1, align 8
  %v3 = getelementptr inbounds i64, ptr @px_plan, i64 2
  %v4 = load i64, ptr %v3, align 8
  %v5 = add i64 %v2, %v4
  ret i64 %v5
}
"""


def test_what_there_is_none_of_is_told_as_a_constant() -> None:
    table = "@px_other = constant [1 x i64] [i64 5]\n@px_plan = constant [3 x i64] [{}]\n"
    for none in (0, -1):
        numbers = numbers_of(table.format(f"i64 7, i64 {none}, i64 3"), "px_plan")
        assert numbers == [7, none, 3]
        left = without(LOADED, "px_plan", {1: none})
        assert f"%v2 = add i64 {none}, 0\n" in left and "i64 1\n" not in left
        assert "%v4 = load i64, ptr %v3" in left and "@px_plan, i64 2" in left
    assert without(LOADED, "px_plan", {0: 0}) == LOADED
    assert without(LOADED, "px_rules", {1: 0, 2: 0}) == LOADED
