-- A session in Neovim, by keys where there are keys; what was seen goes to seen.json.

local seen = {}
local session

local function sleep(ms)
  vim.defer_fn(function()
    local ok, problem = coroutine.resume(session)
    if not ok then
      seen.problem = problem
      vim.fn.writefile({ vim.json.encode(seen) }, "seen.json")
      vim.cmd("qa!")
    end
  end, ms)
  coroutine.yield()
end

local function keys(text)
  vim.api.nvim_input(text)
  sleep(150)
end

local function wait(condition)
  for _ = 1, 400 do
    local found = condition()
    if found then
      return found
    end
    sleep(50)
  end
  error("it did not come: " .. debug.traceback())
end

local function lines()
  return vim.api.nvim_buf_get_lines(0, 0, -1, false)
end

local function shown(what)
  return vim.iter(vim.api.nvim_list_wins()):find(function(window)
    local floats = vim.api.nvim_win_get_config(window).relative ~= ""
    local text = table.concat(vim.api.nvim_buf_get_lines(vim.api.nvim_win_get_buf(window), 0, -1, false), "\n")
    return floats and text:find(what, 1, true)
  end)
end

local function completed(place, text)
  keys("<Esc>gg/" .. place .. "<CR>o<C-u>" .. text)
  sleep(200)
  keys("<C-x><C-o>")
  wait(function() return #vim.fn.complete_info({ "items" }).items > 0 end)
  local found = vim.tbl_map(function(item) return item.abbr end, vim.fn.complete_info({ "items" }).items)
  keys("<C-e><Esc>u")
  return found
end

session = coroutine.create(function()
  local client = wait(function()
    local found = vim.lsp.get_clients({ bufnr = 0 })[1]
    return found and found.initialized and found
  end)
  seen.client = client.name
  wait(function() return #vim.lsp.inlay_hint.get({ bufnr = 0 }) > 0 end)
  seen.hints = vim.tbl_map(function(h) return h.inlay_hint.label end, vim.lsp.inlay_hint.get({ bufnr = 0 }))
  seen.mistakes = #vim.diagnostic.get(0)

  seen.completed = {
    connector = completed("equation", "  connect(crank."),
    name = completed("equation", "  cra"),
    class = completed("FixedTranslation crank", "  Fix"),
    modifier = completed("FixedTranslation crank", "  FixedTranslation q(wi"),
  }

  keys("gg/FixedTranslation crank<CR>wK")
  wait(function() return shown("Rigid rod without mass") or shown("FixedTranslation") end)
  keys("<Esc>gg/FixedTranslation crank<CR><C-]>")
  wait(function() return vim.api.nvim_buf_get_name(0):find("FixedTranslation.pmo", 1, true) end)
  seen.declared = vim.api.nvim_get_current_line()
  keys("<C-o>")
  wait(function() return vim.api.nvim_buf_get_name(0):find("four_bar.pmo", 1, true) end)

  keys("gg/FixedTranslation crank<CR>wgrr")
  wait(function() return #vim.fn.getqflist() > 1 end)
  seen.uses = #vim.fn.getqflist()
  vim.cmd("cclose")

  keys("gg/FixedTranslation crank<CR>w")
  vim.lsp.buf.rename("kurbel")
  wait(function() return table.concat(lines()):find("connect(kurbel.frame_b", 1, true) end)
  seen.renamed = not table.concat(lines()):find("crank.", 1, true)
  keys("u")

  vim.api.nvim_buf_set_lines(0, 10, 10, false, { "     parameter   Real  unused =1 ;" })
  vim.lsp.buf.format({ timeout_ms = 10000 })
  seen.formatted = lines()[11]

  vim.api.nvim_buf_set_lines(0, 10, 11, false, { "  Fixd fixed;" })
  local wrong = wait(function() return vim.diagnostic.get(0)[1] end)
  seen.mistake = wrong.message
  vim.api.nvim_win_set_cursor(0, { wrong.lnum + 1, wrong.col })
  vim.lsp.buf.code_action({ apply = true, filter = function(action) return action.title:find("Fixed", 1, true) end })
  wait(function() return lines()[11] == "  Fixed fixed;" end)
  seen.mended = lines()[11]

  local opened
  vim.ui.open = function(address)
    opened = address
    return { wait = function() return { code = 0 } end }
  end
  vim.cmd("PlanarcView")
  wait(function() return opened end)
  seen.page = opened
  keys("gg/FixedTranslation crank<CR>w")
  opened = nil
  vim.cmd("PlanarcHandbook")
  wait(function() return opened end)
  seen.handbook = opened
  vim.cmd("PlanarcCheck")
  seen.told = wait(function()
    local found = vim.fn.execute("messages")
    return found:find("is complete", 1, true) and found
  end)
  vim.fn.writefile({ vim.json.encode(seen) }, "seen.json")
  vim.cmd("qa!")
end)
coroutine.resume(session)
