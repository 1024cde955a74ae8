"""What is left out of exported models: functions that nothing calls, and those alone."""

from __future__ import annotations

from planarc.export.pruned import calls_in, prune

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
