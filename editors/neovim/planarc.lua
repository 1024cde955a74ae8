-- planarc in Neovim 0.11 or newer: copy to ~/.config/nvim/plugin/planarc.lua
-- What can be done with it stands in README.md.

vim.filetype.add({ extension = { pmo = "modelica", mo = "modelica" } })

vim.lsp.config("planarc", {
  cmd = { "planarc", "lsp" },
  filetypes = { "modelica" },
  root_markers = { "package.order", ".git" },
  init_options = {
    libraries = {}, -- folders of Modelica libraries, such as vim.fn.expand("~/modelica")
    inlayHints = true,
    panel = false, -- the mechanism is shown in the browser
  },
  handlers = {
    ["planarc/checked"] = function() end, -- what each edit came to; for a status line
  },
})
vim.lsp.enable("planarc")

-- :PlanarcView, :PlanarcSimulate, :PlanarcCheck do it with the model of this file; :PlanarcHandbook
-- opens the page of what stands under the cursor, or of the class that is named.
vim.api.nvim_create_autocmd("LspAttach", {
  callback = function(event)
    local client = vim.lsp.get_client_by_id(event.data.client_id)
    if not client or client.name ~= "planarc" then
      return
    end
    for _, name in ipairs({ "view", "simulate", "check" }) do
      vim.api.nvim_buf_create_user_command(event.buf, "Planarc" .. name:gsub("^%l", string.upper), function(given)
        local model = { uri = vim.uri_from_bufnr(event.buf), class = given.fargs[1] }
        client:exec_cmd({ title = name, command = "planarc." .. name, arguments = { model } })
      end, { nargs = "?", desc = "planarc: " .. name .. " a model of this file" })
    end
    vim.api.nvim_buf_create_user_command(event.buf, "PlanarcHandbook", function(given)
      local place = vim.lsp.util.make_position_params(0, client.offset_encoding)
      local asked = { uri = place.textDocument.uri, position = place.position, class = given.fargs[1] }
      client:exec_cmd({ title = "handbook", command = "planarc.handbook", arguments = { asked } })
    end, { nargs = "?", desc = "planarc: the handbook's page of what stands here" })
    vim.bo[event.buf].commentstring = "// %s"
    vim.lsp.inlay_hint.enable(true, { bufnr = event.buf })
  end,
})
