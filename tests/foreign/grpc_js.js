// Makes the calls that stdin lists as JSON, [{rpc, requests, session}], with @grpc/grpc-js and its stock settings, and writes
// for each a line of JSON: {replies} or {replies, code, details}.
//
//     node grpc_js.js ADDRESS FOLDER_OF_PROTO FOLDER_OF_NODE_MODULES
'use strict';
const {createRequire} = require('module');
const [address, protos, modules] = process.argv.slice(2);
const load = createRequire(modules + '/');
const grpc = load('@grpc/grpc-js');
const loader = load('@grpc/proto-loader');

const definition = loader.loadSync('stiefel/v1/simulation.proto', {
  includeDirs: [protos], keepCase: true, longs: String, enums: String, bytes: String, json: true,
});
const {SimulationService} = grpc.loadPackageDefinition(definition).stiefel.v1;
const client = new SimulationService(address, grpc.credentials.createInsecure());

// One call; resolves to what it answers.
function ask({rpc, requests, session}) {
  const metadata = new grpc.Metadata();
  if (session) metadata.set('stiefel-session', session);
  const {requestStream, responseStream} = SimulationService.service[rpc];
  return new Promise((resolve) => {
    const replies = [];
    const failed = (error) => {
      const details = error.metadata && error.metadata.get('grpc-status-details-bin')[0];
      resolve({replies, code: error.code, details: details ? details.toString('base64') : ''});
    };
    if (!responseStream) {
      client[rpc](requests[0], metadata, (error, reply) => error ? failed(error) : resolve({replies: [reply]}));
      return;
    }
    const call = requestStream ? client[rpc](metadata) : client[rpc](requests[0], metadata);
    call.on('data', (reply) => replies.push(reply));
    call.on('error', failed);
    call.on('end', () => resolve({replies}));
    if (requestStream) {
      for (const request of requests) call.write(request);
      call.end();
    }
  });
}

(async () => {
  let text = '';
  for await (const chunk of process.stdin) text += chunk;
  for (const call of JSON.parse(text)) process.stdout.write(JSON.stringify(await ask(call)) + '\n');
  client.close();
})();
